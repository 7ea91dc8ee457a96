/// Division of polygons and strips into triangles.
#pragma once

#include "geometry/files/mesh_file.h"

namespace kagero {

/// The faces of a file. The corners of all faces follow each other.
struct Polygons {
    std::vector<std::uint32_t> corners;  ///< Vertex indices, which must be in range.
    std::vector<std::uint32_t> sizes;    ///< Number of corners of each face.
};

/// Divides polygons into triangles and appends these to the mesh. A polygon may be concave, and it need not be exactly
/// plane. Polygons with one or two corners are counted as points and lines. A remark states the number of polygons
/// whose edges cross. Such a polygon with n corners also gives n − 2 triangles, which need not cover its inside.
void append_polygons(FileMesh& mesh, const Polygons& polygons);

/// Appends the triangles of a strip, in which each vertex forms a triangle with the two vertices before it. The
/// orientation alternates, so that all triangles face the same side. A triangle with two equal indices joins parts of a
/// strip and is left out.
void append_strip(FileMesh& mesh, const std::uint32_t* corners, std::size_t count);

}  // namespace kagero

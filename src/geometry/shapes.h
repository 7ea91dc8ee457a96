/// Objects as triangles: rectangles, boxes, rooms, disks and meshes; the planes of triangles, and axes across a pole.
#pragma once

#include "scene/description.h"

namespace kagero {

/// Triangles in coordinates relative to `space.center`. Every array may be indexed by 3·vertex, normals and uv may be
/// empty.
struct TriangleMesh {
    std::vector<double> vertices;
    std::vector<std::uint32_t> triangles;
    std::vector<double> normals;  ///< 3 per vertex, unit length
    std::vector<double> uv;       ///< 2 per vertex
};

/// Triangles 0 and 1; u along edge_u, v along edge_v, both from 0 to 1.
TriangleMesh rectangle_mesh(const ObjectDescription& object, const Double3& space_center);

/// Two triangles per face: primitive/2 is the face px nx py ny pz nz. u runs to the right and v upward (z; +y on floor
/// and ceiling) as seen from inside a room, from outside a box.
TriangleMesh box_mesh(const ObjectDescription& object, const Double3& space_center);

/// A ring of triangles that covers the disk between its radii and little more.
TriangleMesh disk_mesh(const ObjectDescription& object, const Double3& space_center);

/// nx ny nz d of every triangle: n·q = d with n of unit length.
std::vector<double> planes_of(const TriangleMesh& mesh);

/// Two unit vectors in the plane across `pole`, right-handed with it: the first is +x made orthogonal, or, where the
/// pole lies on the x axis, where +x has gone when the pole was turned there from +z by the shortest way.
std::array<Double3, 2> meridians(const Double3& pole);

/// A vertex in double.
inline Double3 vertex(const TriangleMesh& mesh, std::uint32_t index) {
    const double* v = &mesh.vertices[3 * std::size_t{index}];
    return {v[0], v[1], v[2]};
}

}  // namespace kagero

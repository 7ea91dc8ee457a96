/// Reader of OBJ files.
#pragma once

#include "geometry/files/mesh_file.h"

namespace kagero {

/// Reads the polygons of an OBJ file. Lines and points are counted; free-form geometry is refused. Each combination of
/// the indices of a position, of texture coordinates and of a normal that a face uses becomes one vertex.
FileMesh read_obj(const MeshSource& source);

}  // namespace kagero

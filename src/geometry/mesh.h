/// Triangle meshes from OBJ, PLY and glTF files.
#pragma once

#include "geometry/files/mesh_file.h"
#include "geometry/shapes.h"

namespace kagero {

/// Reads the mesh file of an object. If the object has the materials of its file, they are read too, and triangles
/// without area are left out. Throws InputError if it cannot be read.
FileMesh read_mesh_file(const ObjectDescription& object);

/// Loads the mesh of an object: reads the file, checks it, and applies scale, rotation about x, y and z, and
/// translation. In the result, all vertices are finite and all indices are in range. Triangles without area are left
/// out, and a remark states their number. Throws InputError if the data cannot be used or if no triangle is left. The
/// location of the error is the key `file` of the object, or a line of the mesh file.
TriangleMesh load_mesh(const ObjectDescription& object, const Double3& space_center, std::vector<std::string>& remarks);

}  // namespace kagero

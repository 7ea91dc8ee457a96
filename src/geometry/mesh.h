/// Triangle meshes from OBJ, PLY and glTF files, checked.
#pragma once

#include "geometry/shapes.h"

namespace kagero {

/// Reads, transforms (scale, rotate about x, y, z, translate) and checks the mesh of an object. Every vertex is finite
/// and every index in range, or InputError is thrown at the object's place. Degenerate triangles are left out, with a
/// remark in `remarks`; InputError where no other is left.
TriangleMesh load_mesh(const ObjectDescription& object, const Double3& space_center, std::vector<std::string>& remarks);

}  // namespace kagero

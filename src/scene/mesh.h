/// Triangle meshes from OBJ, PLY and glTF files, checked.
#pragma once

#include "scene/shapes.h"

namespace kagero {

/// Reads, transforms (scale, rotate about x, y, z, translate) and checks the mesh of an object. Every vertex is finite, every
/// index in range and no triangle degenerate, or InputError is thrown at the object's place. `remarks` receives what was left
/// out.
TriangleMesh load_mesh(const ObjectDescription& object, const Double3& space_center, std::vector<std::string>& remarks);

}  // namespace kagero

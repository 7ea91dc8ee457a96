/// Reader of PLY files.
#pragma once

#include "geometry/files/mesh_file.h"

namespace kagero {

/// Reads the polygons and triangle strips of a PLY file. Other elements, such as edges, are skipped, and a remark names
/// them. A file that contains only such elements is refused.
FileMesh read_ply(const MeshSource& source);

}  // namespace kagero

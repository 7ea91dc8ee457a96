/// Reader of glTF files, version 2.0.
#pragma once

#include "geometry/files/mesh_file.h"

namespace kagero {

/// Reads the triangles of the default scene of a .gltf or .glb file, in the coordinates of the scene. Points and lines
/// are counted. Meshes with skins and morph targets are read in their base pose, with a remark. v increases upward, as
/// in the other formats.
FileMesh read_gltf(const MeshSource& source);

}  // namespace kagero

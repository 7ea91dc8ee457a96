/// Reader of MTL files, the materials of OBJ files.
#pragma once

#include "geometry/files/file_material.h"
#include "geometry/files/mesh_file.h"

namespace kagero {

/// The materials of MTL files, by name.
using MtlMaterials = std::map<std::string, FileMaterial>;

/// Reads the MTL files that an OBJ file names and adds their materials: the diffuse colour Kd, the emission Ke and the
/// metallic share Pm, with the textures of the colours. Other properties are counted as unused. Returns the paths of
/// the MTL files. Throws InputError with the line and the material if a file cannot be read or a value is not legal.
std::vector<std::string> read_libraries(const MeshSource& obj, MtlMaterials& materials);

}  // namespace kagero

/// Checks what the importer takes on trust in a glTF file: it follows nodes and brackets by recursion, as deep as they
/// go.
#pragma once

#include <string>

namespace kagero {

/// Whether the file's name says so: .gltf or .glb, in any case.
bool is_gltf(const std::string& path);

/// Throws InputError, placed in the glTF file, where it is not JSON, where its brackets or its nodes are nested deeper
/// than 1000, and where its nodes are not trees.
void check_gltf(const std::string& path);

}  // namespace kagero

/// Checks of glTF files before they are imported. The importer reads nested nodes and brackets by recursion of
/// unlimited depth, which can overflow the stack.
#pragma once

#include <string>

namespace kagero {

/// Returns true if the file name ends in .gltf or .glb, in upper or lower case.
bool is_gltf(const std::string& path);

/// Throws InputError, with the path of the glTF file, if the file is not JSON, if its brackets or nodes are nested
/// deeper than 1000, or if its nodes do not form trees.
void check_gltf(const std::string& path);

}  // namespace kagero

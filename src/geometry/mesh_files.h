/// The files that a mesh file names.
#pragma once

#include <string>
#include <vector>

namespace kagero {

/// Returns the paths of the files that a mesh file names and that are read with it: the buffers and images of a
/// glTF file, and the MTL files and images of an OBJ file. The list is empty for other files, and for a file that
/// cannot be read.
std::vector<std::string> files_of_mesh(const std::string& path);

}  // namespace kagero

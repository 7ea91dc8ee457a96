/// Checks of PLY files before they are imported by assimp, which adds arbitrary faces if the file is truncated.
#pragma once

#include <string>

namespace kagero {

/// Returns true if the file begins with "ply", in upper or lower case.
bool is_ply(const std::string& path);

/// Throws InputError, with a line number of the PLY file, if the header is invalid or if the file does not contain
/// exactly the elements that the header declares.
void check_ply(const std::string& path);

}  // namespace kagero

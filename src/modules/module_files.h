/// Finds and loads the modules of kagero, which are shared libraries: the kernel modules and the image module.
#pragma once

#include <string>

namespace kagero {

/// Returns the path of the module with this file name, in the module folders of the program or the library. Returns ""
/// if no folder contains it.
std::string module_file(const std::string& name);

/// Loads a module and returns the address of its function `entry`. The module stays loaded until the program ends.
/// Throws RunError if the file is not such a module.
void* open_module(const std::string& path, const char* entry);

}  // namespace kagero

/// Finds and loads the modules of kagero, which are shared libraries: the kernel modules and the image module.
#pragma once

#include <string>

namespace kagero {

/// Returns the path of the module with the file name `name`, in the module folders of the program or of the library.
/// Returns "" if no folder contains the module.
std::string module_file(const std::string& name);

/// Loads a module and returns the address of its function `entry`. The module stays loaded until the program ends.
/// Throws RunError if the file cannot be loaded or has no function `entry`.
void* open_module(const std::string& path, const char* entry);

}  // namespace kagero

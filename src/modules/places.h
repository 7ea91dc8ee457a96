/// Where the program's modules lie, and how one is opened.
#pragma once

#include <string>

namespace kagero {

/// The path of a module of this name beside the program or the library; empty where there is none.
std::string module_file(const std::string& name);

/// Loads a module, for as long as the program runs, and returns the address of its one entry. Throws RunError.
void* open_module(const std::string& path, const char* entry);

}  // namespace kagero

/// Finds, picks and loads kernel modules.
#pragma once

#include "kernels/abi.h"

#include <string>
#include <vector>

namespace kagero {

/// One instruction set this build has a module for.
struct IsaInfo {
    std::string name;   ///< "sse2" …
    std::string path;   ///< of the shared module
    bool supported;     ///< by this CPU
};

/// Modules found beside the program, best first.
std::vector<IsaInfo> find_isas();

/// The names in "sse2,avx2", those of all modules that this CPU can run for "all", that of the best for "auto"; best
/// first.
std::vector<std::string> isas_for(const std::string& wish);

/// Throws as load_module does, in the name of the option that asks for it; loads nothing.
void require_isa(const std::string& option, const std::string& wanted);

/// Loads a module for "auto" (the best supported one) or a name; kept loaded until the program ends. Throws InputError
/// for an unknown name or one this CPU cannot run, RunError when no module is found.
const Module& load_module(const std::string& isa);

}  // namespace kagero

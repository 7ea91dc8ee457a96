/// Finds, selects and loads kernel modules.
#pragma once

#include "kernels/abi.h"

#include <string>
#include <vector>

namespace kagero {

/// An instruction set for which this build has a kernel module.
struct IsaInfo {
    std::string name;  ///< "sse2", "avx2" or "avx512".
    std::string path;  ///< Path of the kernel module.
    bool supported;    ///< True if this CPU supports the instruction set.
};

/// Returns the instruction sets whose modules are installed with the program, best first.
std::vector<IsaInfo> find_isas();

/// Returns the instruction sets of a list such as "sse2,avx2" that this CPU supports, best first. The word "all"
/// selects all supported instruction sets, "auto" the best one. Throws RunError if no module for this CPU is found.
std::vector<std::string> find_isa_names(const std::string& list);

/// Throws the exceptions of load_module, without loading a module. `option` is the name of the option that states the
/// instruction set; the message contains it.
void require_isa(const std::string& option, const std::string& name);

/// Loads the module of an instruction set; "auto" selects the best supported one. The module stays loaded until the
/// program ends. Throws InputError if the name is unknown or not supported by this CPU, RunError if no module is found.
const Module& load_module(const std::string& name);

}  // namespace kagero

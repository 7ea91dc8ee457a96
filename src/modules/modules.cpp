#include "modules/modules.h"

#include "error.h"
#include "modules/module_files.h"

#include <map>
#include <mutex>

namespace kagero {
namespace {

/// An instruction set for which a build may have a kernel module.
struct Isa {
    const char* name;
    bool (*supported)();
};

/// All instruction sets, best first. The names are those of kernels/CMakeLists.txt.
constexpr Isa isas[] = {
    {"avx512",
     [] {
         return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512cd") &&
                __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw") &&
                __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("fma");
     }},
    {"avx2", [] { return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"); }},
    {"sse2", [] { return static_cast<bool>(__builtin_cpu_supports("sse2")); }},
};

/// Returns the names of the instruction sets as a list for a message; only supported ones if `supported_only`.
std::string names_of(const std::vector<IsaInfo>& found, bool supported_only) {
    std::string names;
    for (const IsaInfo& isa : found)
        if (isa.supported || !supported_only) append_to_list(names, isa.name);
    return names.empty() ? "none" : names;
}

/// Loads the kernel module of an instruction set. Throws RunError if the module belongs to another version of kagero.
const Module& load_kernels(const IsaInfo& isa) {
    const Module* module = reinterpret_cast<KageroKernels>(open_module(isa.path, "kagero_kernels"))();
    if (module->abi != abi_version)
        throw RunError(isa.path + " belongs to another version of kagero; build or install kagero again");
    return *module;
}

/// Returns the instruction set with this name, or the best supported one for "auto". Throws the exceptions of
/// load_module.
const IsaInfo& find_isa(const std::vector<IsaInfo>& found, const std::string& name, const std::string& option) {
    for (const IsaInfo& isa : found) {
        if (name == "auto" ? !isa.supported : isa.name != name) continue;
        if (!isa.supported)
            throw InputError(option + " " + name + ": this CPU does not support it; supported instruction sets: " +
                             names_of(found, true));
        return isa;
    }
    if (name == "auto")
        throw RunError(
            "no kernel module for this CPU was found in lib/kagero beside the program; build or install kagero again");
    std::vector<std::string> names{"auto"};
    for (const IsaInfo& isa : found) names.push_back(isa.name);
    for (const Isa& isa : isas)
        if (isa.name == name)
            throw InputError(option + " " + name + ": this build of kagero has no module for it; it has modules for " +
                             names_of(found, false));
    const std::string near = near_match(name, names);
    throw InputError(option + (name.empty() ? " with an empty name" : " " + name) + ": not one of auto, " +
                     names_of(found, false) + (near.empty() ? "" : "; did you mean " + near + "?"));
}

}  // namespace

std::vector<IsaInfo> find_isas() {
    std::vector<IsaInfo> found;
    for (const Isa& isa : isas)
        if (const std::string path = module_file(std::string("kagero-kernels-") + isa.name + ".so"); !path.empty())
            found.push_back({isa.name, path, isa.supported()});
    return found;
}

std::vector<std::string> find_isa_names(const std::string& list) {
    const auto contains = [&](const std::string& word) {
        return ("," + list + ",").find("," + word + ",") != std::string::npos;
    };
    std::vector<std::string> names;
    for (const IsaInfo& isa : find_isas()) {
        const bool requested = list == "all" || (contains("auto") && names.empty()) || contains(isa.name);
        if (isa.supported && requested) names.push_back(isa.name);
    }
    if (names.empty()) find_isa(find_isas(), "auto", "--isa");  // throws RunError if no module is found
    return names;
}

void require_isa(const std::string& option, const std::string& name) {
    find_isa(find_isas(), name, option);
}

const Module& load_module(const std::string& name) {
    static std::mutex mutex;
    static std::map<std::string, const Module*> loaded;
    const std::lock_guard lock(mutex);
    const std::vector<IsaInfo> found = find_isas();
    const IsaInfo& isa = find_isa(found, name, "--isa");
    const auto previous = loaded.find(isa.name);
    return previous != loaded.end() ? *previous->second : *(loaded[isa.name] = &load_kernels(isa));
}

}  // namespace kagero

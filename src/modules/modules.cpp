#include "modules/modules.h"

#include "error.h"
#include "modules/places.h"

#include <map>
#include <mutex>

namespace kagero {
namespace {

struct Isa {
    const char* name;
    bool (*supported)();
};

/// Best first. The names are those of kernels/CMakeLists.txt.
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

std::string names_of(const std::vector<IsaInfo>& found, bool supported_only) {
    std::string names;
    for (const IsaInfo& isa : found)
        if (isa.supported || !supported_only) enumerate(names, isa.name);
    return names.empty() ? "none" : names;
}

const Module& kernels_in(const IsaInfo& isa) {
    const Module* module = reinterpret_cast<KageroKernels>(open_module(isa.path, "kagero_kernels"))();
    if (module->abi != abi_version) throw RunError(isa.path + " belongs to another version of kagero; build it anew");
    return *module;
}

const IsaInfo& choose(const std::vector<IsaInfo>& found, const std::string& wanted, const std::string& option) {
    for (const IsaInfo& isa : found) {
        if (wanted == "auto" ? !isa.supported : isa.name != wanted) continue;
        if (!isa.supported)
            throw InputError(option + " " + wanted + ": this CPU cannot run it; it can run " + names_of(found, true));
        return isa;
    }
    if (wanted == "auto") throw RunError("no kernel module for this CPU was found beside the program (lib/kagero)");
    std::vector<std::string> names{"auto"};
    for (const IsaInfo& isa : found) names.push_back(isa.name);
    for (const Isa& isa : isas)
        if (isa.name == wanted)
            throw InputError(option + " " + wanted + ": this program was built without it; it was built with " +
                             names_of(found, false));
    const std::string near = near_match(wanted, names);
    throw InputError(option + (wanted.empty() ? " with an empty name" : " " + wanted) + ": not one of auto, " +
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

std::vector<std::string> isas_for(const std::string& wish) {
    const auto wants = [&](const std::string& word) {
        return ("," + wish + ",").find("," + word + ",") != std::string::npos;
    };
    std::vector<std::string> names;
    for (const IsaInfo& isa : find_isas()) {
        const bool asked_for = wish == "all" || (wants("auto") && names.empty()) || wants(isa.name);
        if (isa.supported && asked_for) names.push_back(isa.name);
    }
    if (names.empty()) choose(find_isas(), "auto", "--isa");  // tells what is missing
    return names;
}

void require_isa(const std::string& option, const std::string& wanted) {
    choose(find_isas(), wanted, option);
}

const Module& load_module(const std::string& wanted) {
    static std::mutex mutex;
    static std::map<std::string, const Module*> loaded;
    const std::lock_guard lock(mutex);
    const std::vector<IsaInfo> found = find_isas();
    const IsaInfo& isa = choose(found, wanted, "--isa");
    const auto known = loaded.find(isa.name);
    return known != loaded.end() ? *known->second : *(loaded[isa.name] = &kernels_in(isa));
}

}  // namespace kagero

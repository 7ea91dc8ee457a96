#include "modules/modules.h"

#include "error.h"

#include <dlfcn.h>

#include <filesystem>
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
         return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
                __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("fma");
     }},
    {"avx2", [] { return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"); }},
    {"sse2", [] { return static_cast<bool>(__builtin_cpu_supports("sse2")); }},
};

/// Where modules lie, seen from the directory of the program or of the library: in a build tree, and installed.
constexpr const char* places[] = {"../lib/kagero", "../" KAGERO_LIBDIR "/kagero", "kagero"};

/// The directories of the program, and of the shared library where these lines are in one.
std::vector<std::filesystem::path> homes() {
    std::vector<std::filesystem::path> all{std::filesystem::read_symlink("/proc/self/exe").parent_path()};
    Dl_info here{};
    if (dladdr(reinterpret_cast<const void*>(&homes), &here) && here.dli_fname)
        all.push_back(std::filesystem::weakly_canonical(here.dli_fname).parent_path());
    return all;
}

/// Empty where there is none.
std::filesystem::path module_of(const char* isa) {
    for (const auto& home : homes())
        for (const char* place : places) {
            const auto path = (home / place / (std::string("kagero-kernels-") + isa + ".so")).lexically_normal();
            if (std::filesystem::exists(path)) return path;
        }
    return {};
}

std::string names_of(const std::vector<IsaInfo>& found, bool supported_only) {
    std::string names;
    for (const IsaInfo& isa : found)
        if (isa.supported || !supported_only) names += (names.empty() ? "" : ", ") + isa.name;
    return names.empty() ? "none" : names;
}

const Module& open_module(const IsaInfo& isa) {
    void* library = dlopen(isa.path.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!library) throw RunError("cannot load " + isa.path + ": " + dlerror());
    const auto entry = reinterpret_cast<KageroKernels>(dlsym(library, "kagero_kernels"));
    if (!entry) throw RunError(isa.path + " is not a kernel module");
    const Module* module = entry();
    if (module->abi != abi_version) throw RunError(isa.path + " belongs to another version of kagero; build it anew");
    return *module;
}

const IsaInfo& choose(const std::vector<IsaInfo>& found, const std::string& wanted) {
    for (const IsaInfo& isa : found) {
        if (wanted == "auto" ? !isa.supported : isa.name != wanted) continue;
        if (!isa.supported) throw InputError("--isa " + wanted + ": this CPU cannot run it; it can run " + names_of(found, true));
        return isa;
    }
    if (wanted == "auto") throw RunError("no kernel module for this CPU was found beside the program (lib/kagero)");
    std::vector<std::string> names{"auto"};
    for (const IsaInfo& isa : found) names.push_back(isa.name);
    const std::string near = near_match(wanted, names);
    throw InputError("--isa " + wanted + ": not one of auto, " + names_of(found, false) +
                     (near.empty() ? "" : "; did you mean " + near + "?"));
}

}  // namespace

std::vector<IsaInfo> find_isas() {
    std::vector<IsaInfo> found;
    for (const Isa& isa : isas)
        if (const auto path = module_of(isa.name); !path.empty()) found.push_back({isa.name, path.string(), isa.supported()});
    return found;
}

std::vector<std::string> isas_for(const std::string& wish) {
    if (wish != "auto") return {wish};
    std::vector<std::string> names;
    for (const IsaInfo& isa : find_isas())
        if (isa.supported) names.push_back(isa.name);
    return names;
}

const Module& load_module(const std::string& wanted) {
    static std::mutex mutex;
    static std::map<std::string, const Module*> loaded;
    const std::lock_guard lock(mutex);
    const std::vector<IsaInfo> found = find_isas();
    const IsaInfo& isa = choose(found, wanted);
    auto [place, fresh] = loaded.try_emplace(isa.name, nullptr);
    if (fresh) place->second = &open_module(isa);
    return *place->second;
}

}  // namespace kagero

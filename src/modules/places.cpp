#include "modules/places.h"

#include "error.h"

#include <dlfcn.h>

#include <filesystem>
#include <vector>

namespace kagero {
namespace {

/// Where modules lie, seen from the directory of the program or of the library: in a build tree, and installed.
constexpr const char* module_places[] = {"../lib/kagero", "../" KAGERO_LIBDIR "/kagero", "kagero"};

/// The directories of the program, and of the shared library where these lines are in one.
std::vector<std::filesystem::path> homes() {
    std::vector<std::filesystem::path> all{std::filesystem::read_symlink("/proc/self/exe").parent_path()};
    Dl_info here{};
    if (dladdr(reinterpret_cast<const void*>(&homes), &here) && here.dli_fname)
        all.push_back(std::filesystem::weakly_canonical(here.dli_fname).parent_path());
    return all;
}

}  // namespace

std::string module_file(const std::string& name) {
    for (const auto& home : homes())
        for (const char* place : module_places) {
            const auto path = (home / place / name).lexically_normal();
            if (std::filesystem::exists(path)) return path.string();
        }
    return {};
}

void* open_module(const std::string& path, const char* entry) {
    void* library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!library) throw RunError("cannot load " + path + ": " + dlerror());
    void* address = dlsym(library, entry);
    if (!address) throw RunError(path + " is not a module of kagero: it has no " + entry);
    return address;
}

}  // namespace kagero

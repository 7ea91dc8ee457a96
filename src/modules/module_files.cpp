#include "modules/module_files.h"

#include "error.h"

#include <dlfcn.h>

#include <filesystem>
#include <vector>

namespace kagero {
namespace {

/// Module folders, relative to the folder of the program or the library: in a build tree, in an installation as seen
/// from the program, and in an installation as seen from the library.
constexpr const char* module_folders[] = {"../lib/kagero", "../" KAGERO_LIBDIR "/kagero", "kagero"};

/// Returns the folder of the program and, if a shared library contains this function, the folder of that library.
std::vector<std::filesystem::path> program_folders() {
    std::vector<std::filesystem::path> folders{std::filesystem::read_symlink("/proc/self/exe").parent_path()};
    Dl_info this_library{};
    if (dladdr(reinterpret_cast<const void*>(&program_folders), &this_library) && this_library.dli_fname)
        folders.push_back(std::filesystem::weakly_canonical(this_library.dli_fname).parent_path());
    return folders;
}

}  // namespace

std::string module_file(const std::string& name) {
    for (const auto& folder : program_folders())
        for (const char* module_folder : module_folders) {
            const auto path = (folder / module_folder / name).lexically_normal();
            if (std::filesystem::exists(path)) return path.string();
        }
    return {};
}

void* open_module(const std::string& path, const char* entry) {
    void* library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!library) throw RunError("the module " + path + " cannot be loaded: " + dlerror());
    void* address = dlsym(library, entry);
    if (!address) throw RunError(path + " is not a module of kagero: it has no function " + entry);
    return address;
}

}  // namespace kagero

#include "modules/module_files.h"

#include "error.h"

#include <dlfcn.h>

#include <filesystem>
#include <string_view>
#include <vector>

namespace kagero {
namespace {

/// Module folders, relative to the folder of the program or the library: in a build tree, in an installation as seen
/// from the program, in an installation as seen from the library, and in both as seen from the Python module.
constexpr const char* module_folders[] = {"../lib/kagero", "../" KAGERO_LIBDIR "/kagero", "kagero", "../../lib/kagero",
                                          "../../../../" KAGERO_LIBDIR "/kagero"};

/// Returns the folder of the shared library that contains this function, if there is one, and that of the program. The
/// library is first, because the program can be one that has other modules of kagero in its folders, such as Python in
/// /usr/bin.
std::vector<std::filesystem::path> program_folders() {
    std::vector<std::filesystem::path> folders;
    Dl_info this_library{};
    // The name of a program that was found in PATH has no slash, and its folder is unknown.
    if (dladdr(reinterpret_cast<const void*>(&program_folders), &this_library) && this_library.dli_fname &&
        std::string_view(this_library.dli_fname).find('/') != std::string_view::npos)
        folders.push_back(std::filesystem::weakly_canonical(this_library.dli_fname).parent_path());
    folders.push_back(std::filesystem::read_symlink("/proc/self/exe").parent_path());
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

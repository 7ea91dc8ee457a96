#include "film/partial_file.h"

#include "error.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace kagero {

namespace fs = std::filesystem;

namespace {

/// Follows the symbolic links at `path`, and returns the path of their final target, which need not exist.
fs::path target_of(fs::path path) {
    constexpr int max_links = 40;
    std::error_code failure;
    for (int i = 0; i < max_links && fs::is_symlink(path, failure); ++i) {
        const fs::path target = fs::read_symlink(path, failure);
        if (failure) break;
        path = path.parent_path() / target;  // an absolute `target` replaces the whole path
    }
    return path;
}

}  // namespace

void check_file_writable(const std::string& path) {
    std::error_code ignored;
    if (path.empty()) throw InputError("the name of the file to write is empty");
    std::error_code failure;
    if (const fs::file_status found = fs::status(path, failure); found.type() == fs::file_type::none)
        throw InputError("cannot write '" + path + "': " + failure.message());
    if (fs::is_directory(path, ignored))
        throw InputError("cannot write '" + path + "': it is a directory; name a file");
    fs::path directory = target_of(path).parent_path();
    if (directory.empty()) directory = ".";
    const std::string directory_name = directory.string();
    if (!fs::exists(directory, ignored))
        throw InputError("cannot write '" + path + "': the directory '" + directory_name +
                         "' does not exist; create it first");
    if (!fs::is_directory(directory, ignored))
        throw InputError("cannot write '" + path + "': '" + directory_name + "' is not a directory");
    const bool is_special_file = fs::exists(path, ignored) && !fs::is_regular_file(path, ignored);
    if (access(is_special_file ? path.c_str() : directory_name.c_str(), W_OK) != 0)
        throw InputError("cannot write '" + path + "': no permission to write to '" +
                         (is_special_file ? path : directory_name) + "'");
}

PartialFile::PartialFile(const std::string& path) : final_(path) {
    std::error_code ignored;
    direct_ = fs::exists(path, ignored) && !fs::is_regular_file(path, ignored);
    if (direct_) {
        temporary_ = path;
        return;
    }
    // If `path` is a symbolic link, its target is replaced, and the link remains.
    const fs::path target = target_of(path);
    final_ = target.string();
    constexpr std::size_t max_stem = 100;  // bytes, below the limit of 255 bytes for a name
    const std::string name =
        "." + target.filename().string().substr(0, max_stem) + ".part" + std::to_string(getpid());
    temporary_ = (target.parent_path() / name).string();
}

PartialFile::~PartialFile() {
    std::error_code ignored;
    if (!completed_ && !direct_) fs::remove(temporary_, ignored);
}

void PartialFile::complete() {
    if (!direct_) {
        std::error_code failure;
        fs::rename(temporary_, final_, failure);
        if (failure) throw RunError("cannot rename the complete file to '" + final_ + "': " + failure.message());
    }
    completed_ = true;
}

void write_file(const std::string& path, const std::function<void(std::ostream&)>& write) {
    PartialFile file(path);
    std::ofstream out(file.temporary(), std::ios::binary);
    if (!out) throw RunError("cannot write '" + path + "': " + std::strerror(errno));
    write(out);
    out.close();
    if (!out) throw RunError("cannot write '" + path + "': writing failed; the disk may be full");
    file.complete();
}

void write_text_file(const std::string& path, const std::string& text) {
    write_file(path, [&](std::ostream& out) { out.write(text.data(), static_cast<std::streamsize>(text.size())); });
}

}  // namespace kagero

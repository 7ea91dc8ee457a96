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

/// The file that a symbolic link names, whether or not it is there.
fs::path target_of(fs::path path) {
    constexpr int most_links = 40;
    std::error_code failure;
    for (int i = 0; i < most_links && fs::is_symlink(path, failure); ++i) {
        const fs::path named = fs::read_symlink(path, failure);
        if (failure) break;
        path = path.parent_path() / named;  // or `named`, where that is absolute
    }
    return path;
}

}  // namespace

void check_file_writable(const std::string& path) {
    std::error_code ignored;
    if (path.empty()) throw InputError("cannot write a file with an empty name");
    std::error_code failure;
    if (const fs::file_status found = fs::status(path, failure); found.type() == fs::file_type::none)
        throw InputError("cannot write '" + path + "': " + failure.message());
    if (fs::is_directory(path, ignored))
        throw InputError("cannot write '" + path + "': it is a directory; name a file");
    fs::path directory = target_of(path).parent_path();
    if (directory.empty()) directory = ".";
    const std::string shown = directory.string();
    if (!fs::exists(directory, ignored))
        throw InputError("cannot write '" + path + "': the directory '" + shown + "' does not exist; create it first");
    if (!fs::is_directory(directory, ignored))
        throw InputError("cannot write '" + path + "': '" + shown + "' is not a directory");
    const bool special = fs::exists(path, ignored) && !fs::is_regular_file(path, ignored);
    if (access(special ? path.c_str() : shown.c_str(), W_OK) != 0)
        throw InputError("cannot write '" + path + "': no permission to write to '" + (special ? path : shown) + "'");
}

namespace {

/// A file being written beside its final place, which it takes by `complete`; else it is removed.
class PartialFile {
public:
    explicit PartialFile(const std::string& path);
    ~PartialFile();
    PartialFile(const PartialFile&) = delete;
    PartialFile& operator=(const PartialFile&) = delete;
    /// The name to write to.
    const std::string& temporary() const { return temporary_; }
    void complete();

private:
    std::string final_, temporary_;
    bool direct_ = false;
    bool completed_ = false;
};

PartialFile::PartialFile(const std::string& path) : final_(path) {
    std::error_code ignored;
    direct_ = fs::exists(path, ignored) && !fs::is_regular_file(path, ignored);
    if (direct_) {
        temporary_ = path;
        return;
    }
    // Through a symbolic link, the file that it names is replaced, not the link.
    const fs::path target = target_of(path);
    final_ = target.string();
    constexpr std::size_t longest_stem = 100;  // of 255 bytes that a name may have
    const std::string name =
        "." + target.filename().string().substr(0, longest_stem) + ".part" + std::to_string(getpid());
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
        if (failure) throw RunError("cannot give the finished file its name '" + final_ + "': " + failure.message());
    }
    completed_ = true;
}

}  // namespace

void write_file(const std::string& path, const std::function<void(std::ostream&)>& write) {
    PartialFile file(path);
    std::ofstream out(file.temporary(), std::ios::binary);
    if (!out) throw RunError("cannot write '" + path + "': " + std::strerror(errno));
    write(out);
    out.close();
    if (!out) throw RunError("cannot write '" + path + "': is the disk full?");
    file.complete();
}

void write_text_file(const std::string& path, const std::string& text) {
    write_file(path, [&](std::ostream& out) { out.write(text.data(), static_cast<std::streamsize>(text.size())); });
}

}  // namespace kagero

/// Files that appear under their name only when they are complete.
#pragma once

#include <string>

namespace kagero {

/// Throws InputError when no file can be put at `path`: its directory is missing or closed, or a directory bears its name.
void check_file_writable(const std::string& path);

/// A file being written beside its final place, under a name with the same extension. It is removed unless `complete` is called.
/// A path that is not a regular file (a pipe, /dev/null) is written directly.
class PartialFile {
public:
    explicit PartialFile(const std::string& path);
    ~PartialFile();
    PartialFile(const PartialFile&) = delete;
    PartialFile& operator=(const PartialFile&) = delete;
    /// The name to write to.
    const std::string& temporary() const { return temporary_; }
    /// Gives the file its name, replacing what was there. Throws RunError.
    void complete();

private:
    std::string final_, temporary_;
    bool direct_ = false;
    bool completed_ = false;
};

/// Writes a whole text. Throws RunError.
void write_text_file(const std::string& path, const std::string& text);

}  // namespace kagero

/// Functions that write a file under a temporary name and rename it when it is complete.
#pragma once

#include <functional>
#include <iosfwd>
#include <string>

namespace kagero {

/// Throws InputError if no file can be written at `path`: the path is empty or invalid, its folder is missing or not
/// writable, or it is itself a folder.
void check_file_writable(const std::string& path);

/// A temporary file in the folder of the final file. The function `complete` renames it to the final name. The
/// destructor removes it if it has not been renamed. A path that is not a regular file is its own temporary file.
class PartialFile {
public:
    explicit PartialFile(const std::string& path);
    ~PartialFile();
    PartialFile(const PartialFile&) = delete;
    PartialFile& operator=(const PartialFile&) = delete;
    /// Returns the name of the temporary file.
    const std::string& temporary() const { return temporary_; }
    /// Renames the temporary file to its final name. Throws RunError if renaming fails.
    void complete();

private:
    std::string final_, temporary_;
    bool direct_ = false;     ///< True if the final file exists and is not a regular file, so it is written directly.
    bool completed_ = false;  ///< True after `complete`.
};

/// Writes a file by calling `write` with a stream. The new file replaces an existing file at `path` when it is
/// complete. A path that is not a regular file (a pipe, /dev/null) is written directly. Throws RunError if writing
/// fails; an existing file is then unchanged.
void write_file(const std::string& path, const std::function<void(std::ostream&)>& write);
/// Writes a file with the given text, as write_file does.
void write_text_file(const std::string& path, const std::string& text);

}  // namespace kagero

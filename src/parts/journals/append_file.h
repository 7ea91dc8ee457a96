/// Files that grow, and that one process uses at a time.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace kagero {

/// A file to which this process alone appends bytes during the lifetime of the object.
class AppendFile {
public:
    /// Opens the file, or creates it, and locks it. Throws InputError if this is not possible, for example because
    /// another process has locked it.
    explicit AppendFile(std::string path);
    ~AppendFile();
    AppendFile(const AppendFile&) = delete;
    AppendFile& operator=(const AppendFile&) = delete;

    const std::string& path() const { return path_; }
    /// Returns the size of the file, in bytes, after the first call of cut().
    std::uint64_t size() const { return size_; }
    /// Removes all bytes after `size` bytes. Returns their number. Throws RunError.
    std::uint64_t cut(std::uint64_t size);
    /// Appends all bytes or none. Returns 0, or the error of the system.
    int append(std::string_view bytes);
    /// Transfers the file to the disk, the first time with its entry in the folder. Returns 0, or the error of the
    /// system. Some file systems do not support this; the data is then in the hands of the system, which writes it
    /// later.
    int transfer();
    /// Removes the file and its content.
    void remove();

private:
    void lock();
    int write_all(std::string_view bytes);

    std::string path_;
    int file_ = -1;
    std::uint64_t size_ = 0;
    bool is_entry_transferred_ = false;
};

}  // namespace kagero

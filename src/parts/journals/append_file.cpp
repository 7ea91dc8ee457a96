#include "parts/journals/append_file.h"

#include "error.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <thread>

namespace kagero {
namespace {

/// Returns true if the open file is the one at `path`. It is not if another process has removed or replaced that.
bool is_file_at(int file, const std::string& path) {
    struct stat opened {
    }, named{};
    return fstat(file, &opened) == 0 && stat(path.c_str(), &named) == 0 && opened.st_ino == named.st_ino &&
           opened.st_dev == named.st_dev;
}

/// Transfers the entry of a file in its folder to the disk.
void transfer_entry(const std::string& path) {
    const std::string folder = std::filesystem::path(path).parent_path().string();
    const int file = open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (file < 0) return;
    fsync(file);  // file systems that do not support this keep the entry themselves
    close(file);
}

[[noreturn]] void refuse_write(const std::string& path) {
    throw RunError("cannot write the journal '" + path + "': " + std::strerror(errno));
}

}  // namespace

AppendFile::AppendFile(std::string path) : path_(std::move(path)) { lock(); }

AppendFile::~AppendFile() { close(file_); }

/// Opens and locks the file. Tries again if another process removed it between these two steps, and for a second if
/// another process has locked it: a process that was killed keeps its lock until its last transfer to the disk ends.
void AppendFile::lock() {
    using Clock = std::chrono::steady_clock;
    const auto deadline = Clock::now() + std::chrono::seconds(1);
    for (;;) {
        file_ = open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
        if (file_ < 0) throw InputError("cannot open the journal '" + path_ + "': " + std::strerror(errno));
        const int error = flock(file_, LOCK_EX | LOCK_NB) == 0 ? 0 : errno;
        if (error == 0 && is_file_at(file_, path_)) return;
        close(file_);
        if (error == EWOULDBLOCK && Clock::now() < deadline) {
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
            continue;
        }
        if (error == EWOULDBLOCK)
            throw InputError("another process uses the journal '" + path_ +
                             "'; wait until it ends, or choose another output with -o");
        if (error != 0) throw InputError("cannot lock the journal '" + path_ + "': " + std::strerror(error));
    }
}

std::uint64_t AppendFile::cut(std::uint64_t size) {
    struct stat found {};
    if (fstat(file_, &found) != 0 || ftruncate(file_, static_cast<off_t>(size)) != 0 ||
        lseek(file_, static_cast<off_t>(size), SEEK_SET) < 0)
        refuse_write(path_);
    size_ = size;
    return static_cast<std::uint64_t>(found.st_size) - size;
}

/// Writes all bytes. Returns 0, or the error of the system.
int AppendFile::write_all(std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t written = ::write(file_, bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) return errno;
        if (written == 0) return ENOSPC;
        bytes.remove_prefix(static_cast<std::size_t>(written));
    }
    return 0;
}

int AppendFile::append(std::string_view bytes) {
    const int error = write_all(bytes);
    if (error == 0) size_ += bytes.size();
    else if (ftruncate(file_, static_cast<off_t>(size_)) == 0) lseek(file_, static_cast<off_t>(size_), SEEK_SET);
    return error;
}

int AppendFile::transfer() {
    if (!is_entry_transferred_) transfer_entry(path_);
    is_entry_transferred_ = true;
    return fdatasync(file_) == 0 || errno == EINVAL || errno == EROFS ? 0 : errno;
}

void AppendFile::remove() {
    if (unlink(path_.c_str()) != 0 && errno != ENOENT)
        throw RunError("cannot remove the journal '" + path_ + "': " + std::strerror(errno));
    // Without its content, a transfer in progress ends at once. The file has no name any more, so errors do not matter.
    if (ftruncate(file_, 0) != 0) return;
}

}  // namespace kagero

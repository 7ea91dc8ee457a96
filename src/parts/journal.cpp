#include "parts/journal.h"

#include "error.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace kagero {
namespace {

using Clock = std::chrono::steady_clock;

/// Time after which the pending records of a thread are written together with a new one.
constexpr std::chrono::milliseconds write_interval{50};
/// Interval in which the writer looks for pending records of threads whose next record takes long.
constexpr std::chrono::milliseconds look_interval{50};
/// Size of pending records that are written at once, in bytes. They should fit in a processor's cache with the data of
/// the renderer.
constexpr std::size_t max_pending = 65536;
/// Size of pending records for which their thread waits until the write of another thread ends, in bytes.
constexpr std::size_t most_pending = 128 * max_pending;
/// Interval of the transfers to the disk.
constexpr std::chrono::seconds transfer_interval{5};

/// Returns true if the open file is the one at `path`. It is not if another process has removed or replaced that.
bool is_file_at(int file, const std::string& path) {
    struct stat opened {
    }, named{};
    return fstat(file, &opened) == 0 && stat(path.c_str(), &named) == 0 && opened.st_ino == named.st_ino &&
           opened.st_dev == named.st_dev;
}

/// Returns a number of the calling thread: 0, 1, 2, … in the order of the first calls.
std::size_t number_of_thread() {
    static std::atomic<std::size_t> threads = 0;
    thread_local const std::size_t number = threads++;
    return number;
}

/// Writes all bytes. Returns 0, or the error of the system.
int write_all(int file, std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t written = ::write(file, bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) return errno;
        if (written == 0) return ENOSPC;
        bytes.remove_prefix(static_cast<std::size_t>(written));
    }
    return 0;
}

/// Transfers the entry of a file in its folder to the disk.
void transfer_entry(const std::string& path) {
    const std::string folder = std::filesystem::path(path).parent_path().string();
    const int file = open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (file < 0) return;
    fsync(file);  // file systems that do not support this keep the entry themselves
    close(file);
}

}  // namespace

Journal::Journal(std::string path) : path_(std::move(path)) {
    lock_file();
    try {
        std::ifstream in(path_, std::ios::binary);
        header_ = read_header(in, path_);
        if (header_) size_ = static_cast<std::uint64_t>(in.tellg());
    } catch (...) {
        close(file_);
        throw;
    }
}

/// Opens and locks the file. Tries again if another process removed it between these two steps, and for a second if
/// another process has locked it: a process that was killed keeps its lock until its last transfer to the disk ends.
void Journal::lock_file() {
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
            throw InputError("another process renders to the journal '" + path_ +
                             "'; wait until it ends, or choose another output with -o");
        if (error != 0) throw InputError("cannot lock the journal '" + path_ + "': " + std::strerror(error));
    }
}

Journal::~Journal() {
    writer_ = {};  // waits for the thread
    if (!removed_) write_pending(Clock::now());
    if (!removed_ && size_ == 0 && !header_) unlink(path_.c_str());
    close(file_);
}

void Journal::refuse_write(int error) const {
    throw RunError("cannot write the journal '" + path_ + "': " + std::strerror(error) +
                   "; the finished tiles remain in it, and the same command continues");
}

void Journal::cut(std::uint64_t size) {
    if (ftruncate(file_, static_cast<off_t>(size)) != 0 || lseek(file_, static_cast<off_t>(size), SEEK_SET) < 0)
        refuse_write(errno);
}

/// Cuts the file, and returns the number of removed bytes.
std::uint64_t Journal::cut_after(std::uint64_t size) {
    struct stat found {};
    if (fstat(file_, &found) != 0) refuse_write(errno);
    size_ = size;
    cut(size_);
    return static_cast<std::uint64_t>(found.st_size) - size_;
}

std::uint64_t Journal::begin(const TileFileHeader& header) {
    const std::uint64_t removed = cut_after(0);
    {
        const std::lock_guard lock(writing_);
        write(encode_header(header));
    }
    refuse_after_error();
    header_ = header;
    return removed;
}

std::uint64_t Journal::read(Film& film, TileResults& results) {
    std::ifstream in(path_, std::ios::binary);
    in.seekg(static_cast<std::streamoff>(size_));
    const TilesRead tiles = read_tiles(in, *header_, film, results);
    return cut_after(tiles.valid_bytes);
}

/// Throws RunError if a write or transfer failed.
void Journal::refuse_after_error() const {
    if (const int error = error_) refuse_write(error);
}

void Journal::append(std::string_view record) {
    refuse_after_error();
    Pending& pending = pending_[number_of_thread() % pending_.size()];
    const std::lock_guard adding(pending.adding);
    pending.records += record;
    const bool is_due = pending.records.size() >= max_pending || Clock::now() - pending.written >= write_interval;
    if (!is_due) return;
    std::unique_lock writing(writing_, std::defer_lock);
    if (pending.records.size() >= most_pending) writing.lock();
    else if (!writing.try_lock()) return;  // another thread is writing; the next record, or the writer, continues
    write(pending.records);
    pending.records.clear();
    pending.written = Clock::now();
    if (!writer_.joinable()) writer_ = std::jthread([this](const std::stop_token& stop) { write_repeatedly(stop); });
    refuse_after_error();
}

/// Writes records, unless an earlier write failed; `writing_` is locked. If this write fails, cuts the file after its
/// last complete record.
void Journal::write(std::string_view records) {
    if (error_ != 0) return;
    if (const int error = write_all(file_, records); error == 0) {
        size_ += records.size();
    } else {
        error_ = error;
        if (ftruncate(file_, static_cast<off_t>(size_)) == 0) lseek(file_, static_cast<off_t>(size_), SEEK_SET);
    }
}

/// Writes the pending records of all threads that have written nothing since a point in time.
void Journal::write_pending(Clock::time_point last) {
    for (Pending& pending : pending_) {
        const std::lock_guard adding(pending.adding);
        if (pending.records.empty() || pending.written > last) continue;
        const std::lock_guard writing(writing_);
        write(pending.records);
        pending.records.clear();
        pending.written = Clock::now();
    }
}

/// Transfers the file to the disk, at first with its entry in the folder. Some file systems do not support the
/// transfer; the data is then in the hands of the system, which writes it later.
void Journal::transfer() {
    if (!is_entry_transferred_.exchange(true)) transfer_entry(path_);
    if (fdatasync(file_) != 0 && errno != EINVAL && errno != EROFS) error_ = errno;
}

/// Writes pending records again and again, and transfers the file to the disk at longer intervals. A run that ends
/// before the first of these does not wait for the disk at all.
void Journal::write_repeatedly(const std::stop_token& stop) {
    std::unique_lock lock(pausing_);
    auto next_transfer = Clock::now() + transfer_interval;
    while (!stop.stop_requested()) {
        write_pending(Clock::now() - write_interval);
        if (Clock::now() >= next_transfer) {
            transfer();
            next_transfer = Clock::now() + transfer_interval;
        }
        stopping_.wait_for(lock, stop, look_interval, [] { return false; });
    }
}

void Journal::sync() {
    write_pending(Clock::now());
    transfer();
    refuse_after_error();
}

void Journal::remove() {
    if (unlink(path_.c_str()) != 0 && errno != ENOENT)
        throw RunError("cannot remove the journal '" + path_ + "': " + std::strerror(errno));
    removed_ = true;
    // Without its content, a transfer in progress ends at once. The file has no name any more, so errors do not matter.
    if (ftruncate(file_, 0) != 0) return;
}

}  // namespace kagero

/// The journal of a render: a tile file that grows with every finished tile, so that a later run can continue.
#pragma once

#include "parts/tile_file.h"

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace kagero {

/// A journal, which no other process can open during the lifetime of the object.
class Journal {
public:
    /// Opens the journal, or creates it. Throws InputError if another process uses it, or if the file is not a journal
    /// that this program can read.
    explicit Journal(std::string path);
    /// Closes the journal. Removes it if nothing was written to it.
    ~Journal();
    Journal(const Journal&) = delete;
    Journal& operator=(const Journal&) = delete;

    const std::string& path() const { return path_; }
    /// Returns the header of the run that began the journal; nullopt if the journal is new.
    const std::optional<TileFileHeader>& header() const { return header_; }
    /// Removes all bytes, and writes the header of a new journal. Returns the number of removed bytes. Throws RunError.
    std::uint64_t begin(const TileFileHeader& header);
    /// Reads all complete tiles, and removes all bytes after them. Returns the number of removed bytes.
    std::uint64_t read(Film& film, TileResults& results);
    /// Appends a record, which is in the file at most 0.1 s later: records of one thread that follow quickly are
    /// written together. A separate thread transfers the file to the disk every five seconds, so that rendering does
    /// not wait for the disk. May be called from several threads. Throws RunError if writing or an earlier transfer
    /// failed; the journal then ends with its last complete record.
    void append(std::string_view record);
    /// Writes all records, and transfers the file to the disk. A run that ends early calls this function.
    void sync();
    /// Removes the file.
    void remove();

private:
    /// Records that are not yet in the file, of one thread or of a few. Those of each thread stay in the cache of its
    /// processor.
    struct Pending {
        std::mutex adding;  ///< Protects the other members. A thread that needs `writing_`, too, locks this one first.
        std::string records;
        std::chrono::steady_clock::time_point written{};  ///< Time of the last write.
    };

    [[noreturn]] void refuse_write(int error) const;
    void refuse_after_error() const;
    void lock_file();
    void cut(std::uint64_t size);
    std::uint64_t cut_after(std::uint64_t size);
    void write(std::string_view records);
    void write_pending(std::chrono::steady_clock::time_point last);
    void transfer();
    void write_repeatedly(const std::stop_token& stop);

    std::string path_;
    int file_ = -1;
    std::optional<TileFileHeader> header_;
    std::uint64_t size_ = 0;  ///< Size of the file up to its last complete record.
    bool removed_ = false;
    std::array<Pending, 64> pending_;  ///< Each thread uses one element; more threads than elements share them.
    std::mutex writing_;               ///< Protects the file and its size.
    std::atomic<int> error_ = 0;       ///< Error of the system in an earlier write or transfer; 0: none.
    std::atomic<bool> is_entry_transferred_ = false;  ///< The entry of the file in its folder is on the disk.
    std::condition_variable_any stopping_;            ///< Ends the pauses of the thread.
    std::mutex pausing_;
    std::jthread writer_;  ///< The last member, because its thread uses the others.
};

}  // namespace kagero

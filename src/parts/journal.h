/// The journal of a render: a tile file that grows with every finished tile, so that a later run can continue.
#pragma once

#include "parts/tile_file.h"
#include "parts/write_block.h"

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

    const std::string& path() const { return file_.path(); }
    /// Returns the header of the run that began the journal; nullopt if the journal is new.
    const std::optional<TileFileHeader>& header() const { return header_; }
    /// Removes all bytes, and writes the header of a new journal. Returns the number of removed bytes. Throws RunError.
    std::uint64_t begin(const TileFileHeader& header);
    /// Reads all complete tiles, and removes all bytes after them. Returns the number of removed bytes. Throws RunError.
    std::uint64_t read(Film& film, TileResults& results);
    /// Appends a record, which is in the file at most 0.1 s later: records of one thread that follow quickly are
    /// written together. A separate thread writes them, and transfers the file to the disk every five seconds, so that
    /// rendering does not wait for the disk unless it is too slow for the records. May be called from several threads.
    /// Throws RunError if writing or a transfer failed earlier; the journal then ends with its last complete record.
    void append(std::string_view record);
    /// Writes all records, and transfers the file to the disk. A run that ends early calls this function, after the
    /// last call of append().
    void sync();
    /// Removes the file.
    void remove();

private:
    using Clock = std::chrono::steady_clock;

    /// Records of one thread, or of a few, that were not handed to the writer yet. Those of each thread stay in the
    /// cache of its processor.
    struct Pending {
        std::mutex adding;  ///< Protects the other members. A thread that needs `queue_`, too, locks this one first.
        std::optional<WriteBlock> block;
        Clock::time_point begun{};  ///< Time of the first record of the block.
    };
    using Blocks = std::vector<WriteBlock>;

    void refuse_after_error() const;
    void begin_blocks();
    WriteBlock new_block(std::size_t size);
    void hand_over(WriteBlock block);
    Blocks blocks_begun_before(Clock::time_point time);
    void write(Blocks& blocks);
    void write_all();
    void transfer();
    void write_repeatedly(const std::stop_token& stop);

    AppendFile file_;
    std::optional<TileFileHeader> header_;
    bool removed_ = false;
    std::array<Pending, 64> pending_;  ///< Each thread uses one element; more threads than elements share them.
    std::mutex writing_;               ///< Protects the file.
    std::atomic<int> error_ = 0;       ///< Error of the system in an earlier write or transfer; 0: none.
    std::mutex queue_;                 ///< Protects the next two members.
    Blocks full_, free_;               ///< Blocks for the writer; blocks without records.
    std::condition_variable_any has_full_, has_space_;
    std::once_flag writer_started_;
    std::jthread writer_;  ///< The last member, because its thread uses the others.
};

}  // namespace kagero

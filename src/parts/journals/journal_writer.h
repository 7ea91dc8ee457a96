/// Appends the finished tiles of a render to its journal.
#pragma once

#include "parts/journals/journal.h"

#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

namespace kagero {

/// A thread that appends finished tiles to a journal at intervals, and transfers the file to the disk at longer ones.
/// Threads that render only add their tiles to a list, so that they neither encode pixels nor wait for the disk. A
/// render that ends within the first interval writes no tile at all.
class JournalWriter {
public:
    /// `header` is that of the journal. `film` contains the pixels of tiles that are added without a record.
    JournalWriter(Journal& journal, const TileFileHeader& header, const Film& film);

    /// Adds a tile whose pixels are in the film, where they do not change any more. May be called from several threads.
    /// Throws RunError if the thread could not write earlier tiles.
    void add(std::uint64_t index, TileReport report);
    /// Adds the record of a tile. See add(index, report).
    void add(std::string record);
    /// Writes all tiles, and transfers the file to the disk. A run that ends early calls this function, after the last
    /// call of add(). Throws RunError.
    void sync();

private:
    /// A tile whose pixels are in the film, or a record.
    struct FinishedTile {
        std::uint64_t index;
        TileReport report;
        std::string record;
    };

    void add(FinishedTile tile);
    void write_finished();
    void write_repeatedly(const std::stop_token& stop);

    Journal& journal_;
    const TileFileHeader& header_;
    const Film& film_;
    std::mutex adding_;  ///< Protects the next two members.
    std::vector<FinishedTile> finished_;
    std::exception_ptr error_;  ///< Error of the thread.
    std::mutex writing_;        ///< Protects the journal and the next member.
    std::string records_;       ///< Records that are written together.
    std::mutex pausing_;
    std::condition_variable_any stopping_;  ///< Ends the pauses of the thread.
    std::jthread writer_;                   ///< The last member, because its thread uses the others.
};

}  // namespace kagero

#include "parts/journals/journal_writer.h"

#include "large_vector.h"

#include <algorithm>
#include <utility>

namespace kagero {
namespace {

using Clock = std::chrono::steady_clock;

/// Size of records that are written together, in bytes.
constexpr std::size_t records_size = std::size_t{1} << 18;
/// Number of tiles for which memory is reserved at once, if there are so many.
constexpr std::uint64_t most_reserved_tiles = std::uint64_t{1} << 16;
/// Shortest pause of the thread.
constexpr std::chrono::duration<double> least_pause{0.005};
/// Interval of the transfers to the disk. A run that ends earlier does not wait for the disk at all.
constexpr std::chrono::seconds transfer_interval{5};

/// Returns an empty vector with memory for n elements.
template <class T>
std::vector<T> reserved(std::size_t n) {
    std::vector<T> elements = large_vector<T>(n, 0);
    elements.clear();
    return elements;
}

}  // namespace

JournalWriter::JournalWriter(Journal& journal, const TileFileHeader& header, const Film& film)
    : journal_(journal), header_(header), film_(film),
      finished_(reserved<FinishedTile>(std::min(header.part.tiles_of(header.grid), most_reserved_tiles))),
      writer_([this](const std::stop_token& stop) { write_repeatedly(stop); }) {}

void JournalWriter::add(std::uint64_t index, TileReport report) { add(FinishedTile{index, std::move(report), {}}); }

void JournalWriter::add(std::string record) { add(FinishedTile{0, {}, std::move(record)}); }

void JournalWriter::add(FinishedTile tile) {
    const std::lock_guard lock(adding_);
    if (error_) std::rethrow_exception(error_);
    finished_.push_back(std::move(tile));
}

/// Writes the tiles that were added since the last call.
void JournalWriter::write_finished() {
    const std::lock_guard writing(writing_);
    std::vector<FinishedTile> tiles;
    {
        const std::lock_guard adding(adding_);
        tiles.swap(finished_);
    }
    const auto write = [this] {
        journal_.append(records_);
        records_.clear();
    };
    records_.clear();
    for (const FinishedTile& tile : tiles) {
        if (tile.record.empty()) records_ += encode_tile(header_, tile.index, tile.report, film_);
        else records_ += tile.record;
        if (records_.size() >= records_size) write();
    }
    if (!records_.empty()) write();
}

void JournalWriter::write_repeatedly(const std::stop_token& stop) try {
    std::unique_lock lock(pausing_);
    auto next_transfer = Clock::now() + transfer_interval;
    const auto pause = std::max(journal_.interval(), least_pause);
    while (!stopping_.wait_for(lock, stop, pause, [&] { return stop.stop_requested(); })) {
        write_finished();
        if (Clock::now() < next_transfer) continue;
        const std::lock_guard writing(writing_);
        journal_.transfer();
        next_transfer = Clock::now() + transfer_interval;
    }
} catch (...) {
    const std::lock_guard lock(adding_);
    error_ = std::current_exception();
}

void JournalWriter::sync() {
    write_finished();
    const std::lock_guard writing(writing_);
    journal_.transfer();
}

}  // namespace kagero

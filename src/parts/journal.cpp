#include "parts/journal.h"

#include "error.h"

#include <unistd.h>

#include <cstring>
#include <fstream>
#include <utility>

namespace kagero {
namespace {

/// Size of the records that are written at once, in bytes. They should fit in a processor's cache with the data of the
/// renderer.
constexpr std::size_t block_size = std::size_t{1} << 18;
/// Number of blocks that wait for the writer, from which on rendering waits, too.
constexpr std::size_t most_full_blocks = 128;
/// Time after which the writer takes a block that is not full, and interval in which it looks for such blocks.
constexpr std::chrono::milliseconds look_interval{50};
/// Interval of the transfers to the disk.
constexpr std::chrono::seconds transfer_interval{5};

/// Returns a number of the calling thread: 0, 1, 2, … in the order of the first calls.
std::size_t number_of_thread() {
    static std::atomic<std::size_t> threads = 0;
    thread_local const std::size_t number = threads++;
    return number;
}

}  // namespace

Journal::Journal(std::string path) : file_(std::move(path)) {
    std::ifstream in(file_.path(), std::ios::binary);
    header_ = read_header(in, file_.path());
}

Journal::~Journal() {
    writer_ = {};  // waits for the thread
    if (!removed_) write_all();
    if (!removed_ && file_.size() == 0 && !header_) unlink(path().c_str());
}

std::uint64_t Journal::begin(const TileFileHeader& header) {
    const std::uint64_t removed = file_.cut(0);
    error_ = file_.append(encode_header(header));
    begin_blocks();
    header_ = header;
    return removed;
}

std::uint64_t Journal::read(Film& film, TileResults& results) {
    std::ifstream in(path(), std::ios::binary);
    read_header(in, path());
    const std::uint64_t removed = file_.cut(read_tiles(in, *header_, film, results).valid_bytes);
    begin_blocks();
    return removed;
}

/// Fills the last block of the file with padding, so that whole blocks can follow.
void Journal::begin_blocks() {
    if (error_ == 0) error_ = file_.append(WriteBlock::padding_after(file_.size()));
    refuse_after_error();
    file_.bypass_cache();
}

/// Throws RunError if a write or transfer failed.
void Journal::refuse_after_error() const {
    if (const int error = error_)
        throw RunError("cannot write the journal '" + path() + "': " + std::strerror(error) +
                       "; the finished tiles remain in it, and the same command continues");
}

/// Returns a block without records that has memory for at least `size` bytes.
WriteBlock Journal::new_block(std::size_t size) {
    const std::lock_guard lock(queue_);
    if (size > block_size || free_.empty()) return WriteBlock(std::max(size, block_size));
    WriteBlock block = std::move(free_.back());
    free_.pop_back();
    return block;
}

/// Hands a block to the writer. Waits if too many others wait for it.
void Journal::hand_over(WriteBlock block) {
    std::unique_lock lock(queue_);
    has_space_.wait(lock, [this] { return full_.size() < most_full_blocks; });
    full_.push_back(std::move(block));
    has_full_.notify_one();
}

void Journal::append(std::string_view record) {
    refuse_after_error();
    std::call_once(writer_started_, [this] {
        writer_ = std::jthread([this](const std::stop_token& stop) { write_repeatedly(stop); });
    });
    Pending& pending = pending_[number_of_thread() % pending_.size()];
    const std::lock_guard adding(pending.adding);
    if (pending.block && !pending.block->fits(record.size())) {
        hand_over(std::move(*pending.block));
        pending.block.reset();
    }
    if (!pending.block) {
        pending.block = new_block(record.size());
        pending.begun = Clock::now();
    }
    pending.block->append(record);
}

/// Takes the blocks with a first record before a point in time, unless their threads are using them.
Journal::Blocks Journal::blocks_begun_before(Clock::time_point time) {
    Blocks blocks;
    for (Pending& pending : pending_) {
        const std::unique_lock adding(pending.adding, std::try_to_lock);
        if (!adding || !pending.block || pending.begun > time) continue;
        blocks.push_back(std::move(*pending.block));
        pending.block.reset();
    }
    return blocks;
}

/// Writes blocks, unless an earlier write failed, and keeps their memory for other records.
void Journal::write(Blocks& blocks) {
    for (WriteBlock& block : blocks) {
        const std::lock_guard lock(writing_);
        if (error_ == 0) error_ = file_.append(block.padded());
    }
    const std::lock_guard lock(queue_);
    for (WriteBlock& block : blocks) {
        block.clear();
        if (block.fits(block_size) && free_.size() < pending_.size()) free_.push_back(std::move(block));
    }
}

/// Writes the records of all threads, none of which appends further ones meanwhile.
void Journal::write_all() {
    Blocks blocks = [this] {
        const std::lock_guard lock(queue_);
        return std::exchange(full_, {});
    }();
    write(blocks);
    blocks = blocks_begun_before(Clock::now());
    write(blocks);
}

void Journal::transfer() {
    const std::lock_guard lock(writing_);
    if (const int error = file_.transfer(); error != 0) error_ = error;
}

/// Writes the blocks that are full or old again and again, and transfers the file to the disk at longer intervals. A run
/// that ends before the first of these does not wait for the disk at all.
void Journal::write_repeatedly(const std::stop_token& stop) {
    auto next_transfer = Clock::now() + transfer_interval;
    while (!stop.stop_requested()) {
        Blocks blocks;
        {
            std::unique_lock lock(queue_);
            has_full_.wait_for(lock, stop, look_interval, [this] { return !full_.empty(); });
            blocks.swap(full_);
        }
        has_space_.notify_all();
        write(blocks);
        blocks = blocks_begun_before(Clock::now() - look_interval);
        write(blocks);
        if (Clock::now() < next_transfer) continue;
        transfer();
        next_transfer = Clock::now() + transfer_interval;
    }
}

void Journal::sync() {
    write_all();
    transfer();
    refuse_after_error();
}

void Journal::remove() {
    file_.remove();
    removed_ = true;
}

}  // namespace kagero

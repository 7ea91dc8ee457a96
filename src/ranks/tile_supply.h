/// Tiles of a picture that are dealt out to the ranks while they render.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <vector>

namespace kagero {

/// The supply of one rank. Rank 0 owns the tiles that are left. It gives the other ranks shares of them on request, and
/// takes shares for itself. The shares become smaller toward the end (guided self-scheduling: Polychronopoulos and
/// Kuck, 1987), so that faster ranks get more tiles and all ranks end at about the same time. A rank requests its next
/// share when half of its last one is left, or what it renders in 12 ms, so that it does not wait for messages. Its
/// shares are not smaller than that, while so many tiles are left. Rank 0 does not wait, and its shares may be smaller.
class TileSupply {
public:
    /// `left` are the numbers of the tiles, on rank 0; it is empty on the other ranks. `request` sends a request for a
    /// share of at least this number of tiles to rank 0; it is empty on rank 0.
    TileSupply(int ranks, std::vector<std::uint64_t> left, std::function<void(std::size_t)> request)
        : ranks_(static_cast<std::size_t>(ranks)), total_(left.size()), left_(left.begin(), left.end()),
          request_(std::move(request)) {}

    /// Requests the first share, so that it has arrived when this rank needs it.
    void request_first() {
        const std::lock_guard lock(mutex_);
        request_share();
    }
    /// Returns the number of the next tile that this rank renders. Returns nothing if no tiles are left, or if `stop`
    /// is set. May wait for a share.
    std::optional<std::uint64_t> next(const std::atomic<bool>& stop) {
        constexpr std::chrono::milliseconds interval_of_looks{10};
        std::unique_lock lock(mutex_);
        if (given_ == 0) begin_ = Clock::now();
        for (;;) {
            const bool has_enough = own_.size() > std::max(half_share_, tiles_ahead());
            if (!has_enough && !is_requested_ && !is_exhausted_) request_share();
            if (!own_.empty()) {
                const std::uint64_t tile = own_.front();
                own_.pop_front();
                ++given_;
                return tile;
            }
            if (is_exhausted_ || stop) return {};
            arrived_.wait_for(lock, interval_of_looks);
        }
    }
    /// Rank 0: removes a share from the tiles that are left, which has at least `fewest` of them if there are so many.
    /// Returns an empty list if there are none.
    std::vector<std::uint64_t> take_share(std::size_t fewest) {
        const std::lock_guard lock(mutex_);
        return cut_share(fewest);
    }
    /// Rank 0: returns true if less than half of the tiles are left. Shares become small, and waiting for them costly.
    bool is_short() {
        const std::lock_guard lock(mutex_);
        return left_.size() < total_ / 2;
    }
    /// Other ranks: adds the share that rank 0 has given on request.
    void receive(const std::vector<std::uint64_t>& share) {
        const std::lock_guard lock(mutex_);
        add(share);
        arrived_.notify_all();
    }

private:
    using Clock = std::chrono::steady_clock;

    /// Returns the number of tiles that this rank renders while it waits for a share, at the rate so far; at least 1.
    std::size_t tiles_ahead() const {
        constexpr std::chrono::duration<double> wait{0.012};
        const std::chrono::duration<double> elapsed = Clock::now() - begin_;
        if (given_ == 0 || elapsed < wait) return 1;
        return static_cast<std::size_t>(static_cast<double>(given_) * (wait / elapsed)) + 1;
    }
    void request_share() {
        is_requested_ = true;
        if (request_) request_(tiles_ahead());
        else add(cut_share(1));
    }
    std::vector<std::uint64_t> cut_share(std::size_t fewest) {
        const std::size_t size = std::min(left_.size(), std::max(fewest, left_.size() / (2 * ranks_)));
        const auto end = left_.begin() + static_cast<std::ptrdiff_t>(size);
        const std::vector<std::uint64_t> share(left_.begin(), end);
        left_.erase(left_.begin(), end);
        return share;
    }
    void add(const std::vector<std::uint64_t>& share) {
        is_requested_ = false;
        is_exhausted_ = share.empty();
        own_.insert(own_.end(), share.begin(), share.end());
        half_share_ = share.size() / 2;
    }

    const std::size_t ranks_, total_;
    std::deque<std::uint64_t> left_, own_;  ///< The tiles of no rank, and those that this rank has got.
    const std::function<void(std::size_t)> request_;
    std::size_t half_share_ = 0;  ///< Half of the number of tiles of the last share.
    std::uint64_t given_ = 0;     ///< Number of tiles that next() has returned.
    Clock::time_point begin_{};   ///< Time of the first call of next().
    bool is_requested_ = false, is_exhausted_ = false;
    std::mutex mutex_;
    std::condition_variable arrived_;
};

}  // namespace kagero

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
/// share when half of its last one is left, or a few tiles, so that it does not wait for messages.
class TileSupply {
public:
    /// `left` are the numbers of the tiles, on rank 0; it is empty on the other ranks. `request` sends a
    /// request for a share to rank 0; it is empty on rank 0.
    TileSupply(int ranks, std::vector<std::uint64_t> left, std::function<void()> request)
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
        for (;;) {
            if (own_.size() <= enough_ && !is_requested_ && !is_exhausted_) request_share();
            if (!own_.empty()) {
                const std::uint64_t tile = own_.front();
                own_.pop_front();
                return tile;
            }
            if (is_exhausted_ || stop) return {};
            arrived_.wait_for(lock, interval_of_looks);
        }
    }
    /// Rank 0: removes a share from the tiles that are left. Returns an empty list if there are none.
    std::vector<std::uint64_t> take_share() {
        const std::lock_guard lock(mutex_);
        return cut_share();
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
    static constexpr std::size_t fewest = 4;  ///< The smallest share, while so many are left.

    void request_share() {
        is_requested_ = true;
        if (request_) request_();
        else add(cut_share());
    }
    std::vector<std::uint64_t> cut_share() {
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
        enough_ = std::max(fewest, share.size() / 2);
    }

    const std::size_t ranks_, total_;
    std::deque<std::uint64_t> left_, own_;  ///< The tiles of no rank, and those that this rank has got.
    const std::function<void()> request_;
    std::size_t enough_ = 0;  ///< Number of own tiles at which a further share is requested.
    bool is_requested_ = false, is_exhausted_ = false;
    std::mutex mutex_;
    std::condition_variable arrived_;
};

}  // namespace kagero

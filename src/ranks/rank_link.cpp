#include "ranks/rank_link.h"

#include <algorithm>
#include <numeric>

namespace kagero {

RankLink::RankLink(Communicator& ranks, std::function<void(const RankMessage&)> receive, std::function<void()> idle,
                   LinkTimes times)
    : ranks_(ranks), receive_(std::move(receive)), idle_(std::move(idle)), times_(times),
      heard_(static_cast<std::size_t>(ranks.size())) {
    peers_.assign(ranks.rank() == 0 ? heard_.size() - 1 : 1, 0);
    if (ranks.rank() == 0) std::iota(peers_.begin(), peers_.end(), 1);
}

void RankLink::start(std::function<void()> failed) {
    heard_.assign(heard_.size(), Clock::now());
    shown_ = latest_exchange_ = Clock::now();
    thread_ = std::jthread([this, failed = std::move(failed)] {
        try {
            exchange();
        } catch (const std::exception& error) {
            failure_ = error.what();
            failed();
        }
    });
}

void RankLink::post(int to, int kind, std::string bytes) {
    const std::lock_guard lock(posting_);
    posted_.push_back({to, kind, std::move(bytes)});
}

void RankLink::wake() {
    const std::lock_guard lock(posting_);
    is_woken_ = true;
    woken_.notify_one();
}

void RankLink::post_to_all(int kind, const std::string& bytes) {
    for (const int peer : peers_) post(peer, kind, bytes);
}

void RankLink::join() {
    thread_ = {};
    if (!failure_.empty()) throw LostRank(failure_);
}

void RankLink::exchange() {
    for (;;) {
        bool was_busy = receive_all();
        idle_();
        was_busy = send_all() || was_busy;
        if (finishing_ && ranks_.unsent() == 0) return;
        show_life();
        forgive_own_pause();
        if (!finishing_) check_lost();
        if (!was_busy || !is_expecting_) pause();
    }
}

/// Waits until this rank looks for further messages. Every turn of the thread takes processor time from a thread that
/// renders.
void RankLink::pause() {
    std::unique_lock lock(posting_);
    const double seconds = is_expecting_ ? times_.pause : std::max(times_.pause, times_.long_pause);
    woken_.wait_for(lock, std::chrono::duration<double>(seconds), [this] { return is_woken_; });
    is_woken_ = false;
}

bool RankLink::receive_all() {
    bool any = false;
    while (const auto message = ranks_.receive()) {
        any = true;
        heard_[static_cast<std::size_t>(message->from)] = Clock::now();
        if (message->kind != alive) receive_(*message);
    }
    return any;
}

bool RankLink::send_all() {
    std::vector<Posted> posted;
    {
        const std::lock_guard lock(posting_);
        posted.swap(posted_);
    }
    for (Posted& message : posted) ranks_.send(message.to, message.kind, std::move(message.bytes));
    ranks_.unsent();
    return !posted.empty();
}

void RankLink::show_life() {
    if (finishing_ || Clock::now() - shown_ < std::chrono::duration<double>(times_.heartbeat)) return;
    shown_ = Clock::now();
    for (const int peer : peers_) ranks_.send(peer, alive, "");
}

/// A scheduler can stop all ranks for a while. A rank that was stopped itself does not count the silence of the others.
void RankLink::forgive_own_pause() {
    const auto now = Clock::now();
    if (now - latest_exchange_ > std::chrono::duration<double>(times_.heartbeat)) heard_.assign(heard_.size(), now);
    latest_exchange_ = now;
}

void RankLink::check_lost() const {
    const auto now = Clock::now();
    for (const int peer : peers_)
        if (now - heard_[static_cast<std::size_t>(peer)] > std::chrono::duration<double>(times_.lost_after))
            throw LostRank("rank " + std::to_string(peer) + " is lost: nothing has arrived from it for " +
                           std::to_string(static_cast<int>(times_.lost_after)) + " seconds");
}

}  // namespace kagero

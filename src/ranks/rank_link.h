/// The exchange of messages during the work of a rank.
#pragma once

#include "ranks/communicator.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <stdexcept>
#include <thread>

namespace kagero {

/// Thrown if a rank has not sent anything for a long time, or if messages cannot be exchanged. Collective functions
/// cannot be used any more.
class LostRank : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// Times of the exchange, in seconds.
struct LinkTimes {
    double pause = 1e-3;       ///< Pause before a rank that expects a message looks for it again.
    double heartbeat = 5;      ///< Interval of the messages by which a rank shows that it runs.
    double lost_after = 60;    ///< A rank is lost if nothing has arrived from it for this time.
    double long_pause = 8e-3;  ///< The same for a rank that expects none. Its results are sent at these intervals.
};

/// Exchanges messages in a thread of its own, so that threads that render never wait for other ranks. Rank 0 exchanges
/// messages with all ranks, the others only with rank 0.
class RankLink {
public:
    using Clock = std::chrono::steady_clock;

    /// `receive` handles a message, and `idle` is called between messages. Both are called in the thread of the link,
    /// and may call post() and finish(). The link runs from start() until finish().
    RankLink(Communicator& ranks, std::function<void(const RankMessage&)> receive, std::function<void()> idle,
             LinkTimes times = {});
    RankLink(const RankLink&) = delete;
    RankLink& operator=(const RankLink&) = delete;

    /// Starts the thread. `failed` is called in it if a function of the link throws, or if a rank is lost.
    void start(std::function<void()> failed);
    /// Sends a message after the present pause, in the order of the calls. May be called from any thread.
    void post(int to, int kind, std::string bytes);
    /// Ends the present pause, so that the posted messages are sent at once. May be called from any thread.
    void wake();
    /// States whether this rank waits for a message. May be called from any thread. At first, it does not.
    void expect(bool is_expecting) { is_expecting_ = is_expecting; }
    /// Sends a message to all ranks with which this rank exchanges messages.
    void post_to_all(int kind, const std::string& bytes);
    /// Ends the thread after all messages are sent. Called by `receive` or `idle`.
    void finish() { finishing_ = true; }
    /// Waits until the thread has ended. Throws LostRank if it ended early.
    void join();

private:
    struct Posted {
        int to, kind;
        std::string bytes;
    };
    /// Kind of the messages by which a rank shows that it runs.
    static constexpr int alive = 0;

    void exchange();
    bool receive_all();
    bool send_all();
    void show_life();
    void forgive_own_pause();
    void check_lost() const;
    void pause();

    Communicator& ranks_;
    const std::function<void(const RankMessage&)> receive_;
    const std::function<void()> idle_;
    const LinkTimes times_;
    std::vector<int> peers_;
    std::vector<Clock::time_point> heard_;  ///< Time of the latest message of each rank.
    Clock::time_point shown_;               ///< Time of the latest heartbeat of this rank.
    Clock::time_point latest_exchange_;     ///< Time of the latest turn of the thread.
    bool finishing_ = false;
    std::atomic<bool> is_expecting_ = false;
    std::mutex posting_;
    std::condition_variable woken_;
    bool is_woken_ = false;
    std::vector<Posted> posted_;
    std::string failure_;  ///< Reason why the thread ended early; empty if it did not.
    std::jthread thread_;
};

}  // namespace kagero

#include "render/threads.h"

#include "error.h"

#include <atomic>
#include <exception>
#include <system_error>
#include <thread>
#include <vector>

#include <pthread.h>
#include <sched.h>

namespace kagero {
namespace {

/// Puts each of a team's threads on a processor of its own, once, where the team has one for every processor the
/// program may use.
///
/// Linux (6.18 seen) at times starts a thread on its creator's processor and leaves both there for tens of milliseconds
/// while another is idle: longer than a picture takes. Afterwards the scheduler may move them as it likes.
class Places {
public:
    explicit Places(unsigned threads) : home_(sched_getcpu()) {
        // Fails beyond 1024 processors; and a smaller team might be sent to those that others use.
        known_ = sched_getaffinity(0, sizeof allowed_, &allowed_) == 0 && home_ >= 0 && CPU_COUNT(&allowed_) > 1 &&
                 threads >= static_cast<unsigned>(CPU_COUNT(&allowed_));
    }

    /// Moves number i of the team i processors on from where its creator was. Called by the creator: the thread itself
    /// may have to wait for its first turn.
    void give(std::jthread& thread, unsigned i) const {
        if (!known_) return;
        int processor = home_;
        for (unsigned left = i; left > 0;) {
            processor = (processor + 1) % CPU_SETSIZE;
            left -= CPU_ISSET(processor, &allowed_);
        }
        cpu_set_t one;
        CPU_ZERO(&one);
        CPU_SET(processor, &one);
        const pthread_t handle = thread.native_handle();
        if (pthread_setaffinity_np(handle, sizeof one, &one) == 0)
            pthread_setaffinity_np(handle, sizeof allowed_, &allowed_);
    }

private:
    cpu_set_t allowed_;
    int home_;
    bool known_;
};

}  // namespace

void on_threads(unsigned threads, const std::function<void(unsigned)>& task) {
    std::vector<std::exception_ptr> failures(threads);
    const auto guarded = [&](unsigned i) {
        try {
            task(i);
        } catch (...) {
            failures[i] = std::current_exception();
        }
    };
    {
        const Places places(threads);
        enum Gate { closed, open, in_vain };
        std::atomic<Gate> gate = closed;
        std::vector<std::jthread> team;
        const auto let = [&](Gate how) { gate = how, gate.notify_all(); };
        const auto member = [&](unsigned i) {
            gate.wait(closed);
            if (gate == open) guarded(i);
        };
        try {
            for (unsigned i = 1; i < threads; ++i) places.give(team.emplace_back(member, i), i);
        } catch (const std::system_error&) {
            let(in_vain);
            throw RunError("the system starts " + std::to_string(team.size() + 1) + " of " + std::to_string(threads) +
                           " threads and no more: ask for fewer by --threads");
        }
        let(open);
        guarded(0);
    }
    for (const std::exception_ptr& failure : failures)
        if (failure) std::rethrow_exception(failure);
}

}  // namespace kagero

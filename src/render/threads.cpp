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

/// Moves each new thread to a different processor once, if there are at least as many threads as processors that the
/// program may use. Afterwards the scheduler may move the threads freely.
///
/// Linux (observed with 6.18) sometimes starts a thread on its creator's processor and leaves both there for tens of
/// milliseconds, although other processors are idle. A picture can take less time than that.
class ProcessorAssignment {
public:
    explicit ProcessorAssignment(unsigned threads) : creator_processor_(sched_getcpu()) {
        // sched_getaffinity fails beyond 1024 processors. Fewer threads than processors are not assigned, because they
        // could be moved to processors that other programs use.
        enabled_ = sched_getaffinity(0, sizeof allowed_, &allowed_) == 0 && creator_processor_ >= 0 &&
                   CPU_COUNT(&allowed_) > 1 && threads >= static_cast<unsigned>(CPU_COUNT(&allowed_));
    }

    /// Moves thread number i to the i-th allowed processor after that of its creator. The creator calls this, because
    /// the thread itself may not be scheduled yet.
    void assign(std::jthread& thread, unsigned i) const {
        if (!enabled_) return;
        int processor = creator_processor_;
        for (unsigned remaining = i; remaining > 0;) {
            processor = (processor + 1) % CPU_SETSIZE;
            remaining -= CPU_ISSET(processor, &allowed_);
        }
        cpu_set_t target;
        CPU_ZERO(&target);
        CPU_SET(processor, &target);
        const pthread_t handle = thread.native_handle();
        if (pthread_setaffinity_np(handle, sizeof target, &target) == 0)
            pthread_setaffinity_np(handle, sizeof allowed_, &allowed_);
    }

private:
    cpu_set_t allowed_;
    int creator_processor_;
    bool enabled_;
};

}  // namespace

void run_on_threads(unsigned threads, const std::function<void(unsigned)>& task) {
    std::vector<std::exception_ptr> failures(threads);
    const auto guarded = [&](unsigned i) {
        try {
            task(i);
        } catch (...) {
            failures[i] = std::current_exception();
        }
    };
    {
        const ProcessorAssignment processors(threads);
        enum Gate { closed, open, aborted };
        std::atomic<Gate> gate = closed;
        std::vector<std::jthread> workers;
        const auto set_gate = [&](Gate state) {
            gate = state;
            gate.notify_all();
        };
        const auto worker = [&](unsigned i) {
            gate.wait(closed);
            if (gate == open) guarded(i);
        };
        try {
            for (unsigned i = 1; i < threads; ++i) processors.assign(workers.emplace_back(worker, i), i);
        } catch (const std::system_error&) {
            set_gate(aborted);
            throw RunError("the system started only " + std::to_string(workers.size() + 1) + " of " +
                           std::to_string(threads) + " threads; reduce their number with --threads");
        }
        set_gate(open);
        guarded(0);
    }
    for (const std::exception_ptr& failure : failures)
        if (failure) std::rethrow_exception(failure);
}

}  // namespace kagero

#include "python/work.h"

#include "error.h"

#include <tbb/global_control.h>

#include <chrono>
#include <condition_variable>
#include <exception>
#include <optional>
#include <thread>

namespace py = pybind11;

namespace kagero {
namespace {

constexpr auto polling_interval = std::chrono::milliseconds(20);

std::atomic<int> active_runs = 0;
bool threads_are_lost = false;  ///< True if this process was forked while threads of kagero or TBB existed.
bool tbb_has_ended = true;      ///< True if before_fork has ended all threads of TBB.

/// State that the thread of the work and the calling thread share.
class SharedRun {
public:
    /// The control of the work. It must not outlive this object.
    RunControl control() {
        RunControl control;
        control.stop = &stop;
        control.progress = [this](double done, double seconds) {
            const std::lock_guard lock(mutex_);
            progress_ = {done, seconds};
        };
        return control;
    }
    /// Calls the work and stores its exception.
    void run(const std::function<void(const RunControl&)>& work) {
        try {
            work(control());
        } catch (...) {
            failure = std::current_exception();
        }
        const std::lock_guard lock(mutex_);
        finished_ = true;
        changed_.notify_all();
    }
    /// Waits until the work has returned or the polling interval has passed. Returns true if the work has returned.
    bool wait() {
        std::unique_lock lock(mutex_);
        return changed_.wait_for(lock, polling_interval, [this] { return finished_; });
    }
    /// Returns the last progress, once.
    std::optional<std::pair<double, double>> take_progress() {
        const std::lock_guard lock(mutex_);
        return std::exchange(progress_, std::nullopt);
    }

    std::atomic<bool> stop = false;
    std::exception_ptr failure;

private:
    std::mutex mutex_;
    std::condition_variable changed_;
    bool finished_ = false;
    std::optional<std::pair<double, double>> progress_;
};

/// Handles signals and reports progress while a run is in progress. The interpreter lock must be held.
class Supervisor {
public:
    Supervisor(SharedRun& run, const py::object& progress) : run_(run), progress_(progress) {}

    /// Handles signals that have arrived, and passes on the last progress. Exceptions stop the run.
    void poll() {
        try {
            if (PyErr_CheckSignals() != 0) throw py::error_already_set();
            const auto progress = run_.take_progress();
            if (progress && !progress_.is_none() && !run_.stop) progress_(progress->first, progress->second);
        } catch (py::error_already_set& error) {
            run_.stop = true;
            if (error.matches(PyExc_KeyboardInterrupt)) interrupted = true;
            else if (!raised_) raised_.emplace(error);
        }
    }
    /// Throws the exception that has stopped the run, if it is not KeyboardInterrupt.
    void rethrow() {
        if (raised_) throw py::error_already_set(std::move(*raised_));
    }

    bool interrupted = false;

private:
    SharedRun& run_;
    const py::object& progress_;
    std::optional<py::error_already_set> raised_;
};

struct RunCount {
    RunCount() { ++active_runs; }
    ~RunCount() { --active_runs; }
};

}  // namespace

bool run_with_signals(const py::object& progress, const std::function<void(const RunControl&)>& work) {
    if (threads_are_lost)
        throw RunError(
            "this process was forked from a process in which kagero was running, and lacks its threads; use "
            "multiprocessing.set_start_method(\"spawn\"), or fork when no run is in progress");
    const RunCount count;
    SharedRun run;
    Supervisor supervisor(run, progress);
    {
        const std::jthread worker([&] { run.run(work); });
        for (bool finished = false; !finished;) {
            {
                const py::gil_scoped_release release;
                finished = run.wait();
            }
            supervisor.poll();
        }
    }
    supervisor.rethrow();
    if (run.failure) std::rethrow_exception(run.failure);
    return supervisor.interrupted;
}

void before_fork() {
    tbb::task_scheduler_handle scheduler{tbb::attach{}};
    tbb_has_ended = active_runs == 0 && tbb::finalize(scheduler, std::nothrow);
}

void after_fork_in_child() {
    threads_are_lost = threads_are_lost || active_runs > 0 || !tbb_has_ended;
    active_runs = 0;
}

}  // namespace kagero

/// Runs of the Python module: without the global interpreter lock, with signals, progress, and protection from fork.
#pragma once

#include "render/run_report.h"

#include <pybind11/pybind11.h>

#include <functional>

namespace kagero {

/// Calls `work` on another thread, and returns when it has returned. The calling thread releases the interpreter lock.
/// Meanwhile it handles signals, and calls progress(done, seconds) unless `progress` is None. Returns true if Ctrl-C
/// (KeyboardInterrupt) has stopped the run; `work` then returns what is finished. Any other exception of a signal
/// handler or of `progress` also stops the run, and is thrown afterwards. Throws the exceptions of `work`, and RunError
/// in a process that was forked during a run.
bool run_with_signals(const pybind11::object& progress, const std::function<void(const RunControl&)>& work);

/// Ends the threads of TBB, which a forked process would lack. To be called before fork.
void before_fork();
/// Records that this process is a copy. To be called in the new process after fork.
void after_fork_in_child();

}  // namespace kagero

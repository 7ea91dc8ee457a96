/// Execution of a task on several threads.
#pragma once

#include <functional>

namespace kagero {

/// Calls task(0) on this thread and task(1) … task(threads − 1) each on a new thread, and returns when all calls have
/// returned. Rethrows the exception of the first task that threw one. If the system cannot start all threads, throws
/// RunError before any call.
///
/// Each call of run_on_threads creates its threads and does not use TBB's thread pool. On a busy machine, a worker of
/// that pool begins later than a new thread.
void run_on_threads(unsigned threads, const std::function<void(unsigned)>& task);

}  // namespace kagero

/// Threads, and what they share out among themselves.
#pragma once

#include <functional>

namespace kagero {

/// Calls task(0) … task(threads − 1), each on a thread of its own, and waits for them. Throws what one of them threw;
/// RunError, before any is called, where the system starts fewer.
///
/// Plain threads, made anew, and not TBB's: beside busy processes a worker of TBB's pool joins later than a new thread
/// does.
void on_threads(unsigned threads, const std::function<void(unsigned)>& task);

}  // namespace kagero

/// Threads, and what they share out among themselves.
#pragma once

#include <functional>

namespace kagero {

/// Calls task(0) … task(threads − 1), each on a thread of its own, and waits for them. Throws what one of them threw.
///
/// Plain threads, made anew, and not TBB's: beside six busy processes on two cores the worker of TBB's pool joined 9 … 460 ms
/// late (the room's whole render takes 1 s there), a new thread within 4 ms.
void on_threads(unsigned threads, const std::function<void(unsigned)>& task);

}  // namespace kagero

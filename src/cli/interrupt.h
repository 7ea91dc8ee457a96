/// Ctrl-C, asked for politely.
#pragma once

#include <atomic>

namespace kagero {

/// While it lives, the first SIGINT (or SIGTERM) sets `requested`; a second one ends the program as if nobody had listened.
class InterruptGuard {
public:
    InterruptGuard();
    ~InterruptGuard();
    InterruptGuard(const InterruptGuard&) = delete;
    InterruptGuard& operator=(const InterruptGuard&) = delete;
    static const std::atomic<bool>* requested();
};

}  // namespace kagero

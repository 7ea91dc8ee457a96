/// What other programs and Ctrl-C say to this one.
#pragma once

#include <atomic>

namespace kagero {

/// While it lives, the first SIGINT (or SIGTERM) sets `requested`; a second one ends the program as if nobody had
/// listened.
class InterruptGuard {
public:
    InterruptGuard();
    ~InterruptGuard();
    InterruptGuard(const InterruptGuard&) = delete;
    InterruptGuard& operator=(const InterruptGuard&) = delete;
    static const std::atomic<bool>* requested();
};

/// While it lives, SIGUSR1 sets `wanted`; whoever answers takes it back. Without it that signal ends the program.
class SnapshotGuard {
public:
    SnapshotGuard();
    ~SnapshotGuard();
    SnapshotGuard(const SnapshotGuard&) = delete;
    SnapshotGuard& operator=(const SnapshotGuard&) = delete;
    static std::atomic<bool>* wanted();
};

}  // namespace kagero

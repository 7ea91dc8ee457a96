/// Signals that interrupt the program or request a snapshot.
#pragma once

#include <atomic>

namespace kagero {

/// Handler of SIGINT and SIGTERM during the lifetime of the object. The first signal sets `requested`; a second one
/// terminates the program.
class InterruptGuard {
public:
    InterruptGuard();
    ~InterruptGuard();
    InterruptGuard(const InterruptGuard&) = delete;
    InterruptGuard& operator=(const InterruptGuard&) = delete;
    static const std::atomic<bool>* requested();
};

/// Handler of SIGUSR1 during the lifetime of the object. The signal sets `requested`; the run that takes the snapshot
/// resets it. Without a handler, SIGUSR1 terminates the program.
class SnapshotGuard {
public:
    SnapshotGuard();
    ~SnapshotGuard();
    SnapshotGuard(const SnapshotGuard&) = delete;
    SnapshotGuard& operator=(const SnapshotGuard&) = delete;
    static std::atomic<bool>* requested();
};

}  // namespace kagero

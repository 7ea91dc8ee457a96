#include "cli/interrupt.h"

#include <csignal>
#include <initializer_list>

namespace kagero {

namespace {

// Signal handlers can access only static variables, which must be lock-free.
std::atomic<bool> interrupted{false}, snapshot_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free);

/// Handlers before the guards were created, by signal. The destructors of the guards restore them.
struct sigaction previous[NSIG];

void set(int signal, void (*handler)(int), int flags) {
    struct sigaction action {};
    action.sa_handler = handler;
    action.sa_flags = flags;
    sigaction(signal, &action, &previous[signal]);
}

void restore(int signal) { sigaction(signal, &previous[signal], nullptr); }

}  // namespace

InterruptGuard::InterruptGuard() {
    interrupted = false;
    const auto handler = [](int) { interrupted = true; };
    // SA_RESETHAND restores the default handler before the second signal.
    for (const int signal : {SIGINT, SIGTERM}) set(signal, handler, SA_RESETHAND | SA_RESTART);
}

InterruptGuard::~InterruptGuard() {
    for (const int signal : {SIGINT, SIGTERM}) restore(signal);
}

const std::atomic<bool>* InterruptGuard::requested() { return &interrupted; }

SnapshotGuard::SnapshotGuard() {
    snapshot_requested = false;
    set(
        SIGUSR1, [](int) { snapshot_requested = true; }, SA_RESTART);
}

SnapshotGuard::~SnapshotGuard() { restore(SIGUSR1); }

std::atomic<bool>* SnapshotGuard::requested() { return &snapshot_requested; }

}  // namespace kagero

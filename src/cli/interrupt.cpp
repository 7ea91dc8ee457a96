#include "cli/interrupt.h"

#include <csignal>
#include <initializer_list>

namespace kagero {

namespace {

// Signal handlers can reach nothing else; they live here and nowhere else.
std::atomic<bool> interrupted{false}, snapshot_wanted{false};
static_assert(std::atomic<bool>::is_always_lock_free);

/// Handlers that were there before, which come back.
struct sigaction before[NSIG];

void set(int signal, void (*handler)(int), int flags) {
    struct sigaction action {};
    action.sa_handler = handler;
    action.sa_flags = flags;
    sigaction(signal, &action, &before[signal]);
}

void restore(int signal) {
    sigaction(signal, &before[signal], nullptr);
}

}  // namespace

InterruptGuard::InterruptGuard() {
    interrupted = false;
    const auto note = [](int) { interrupted = true; };
    // SA_RESETHAND: the second signal finds the default handler.
    for (const int signal : {SIGINT, SIGTERM}) set(signal, note, SA_RESETHAND | SA_RESTART);
}

InterruptGuard::~InterruptGuard() {
    for (const int signal : {SIGINT, SIGTERM}) restore(signal);
}

const std::atomic<bool>* InterruptGuard::requested() {
    return &interrupted;
}

SnapshotGuard::SnapshotGuard() {
    snapshot_wanted = false;
    set(
        SIGUSR1, [](int) { snapshot_wanted = true; }, SA_RESTART);
}

SnapshotGuard::~SnapshotGuard() {
    restore(SIGUSR1);
}

std::atomic<bool>* SnapshotGuard::wanted() {
    return &snapshot_wanted;
}

}  // namespace kagero

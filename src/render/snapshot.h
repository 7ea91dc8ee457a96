/// Snapshots of the film while threads write to it.
#pragma once

#include "render/run_report.h"

#include <mutex>
#include <new>
#include <optional>
#include <shared_mutex>

namespace kagero {

/// Takes snapshots of the film. Threads write pixels concurrently. A thread that finds a request for a snapshot copies
/// the film; the other threads cannot write pixels during the copy.
class Snapshots {
public:
    Snapshots(const RunControl& control, const Film& film)
        : control_(control), film_(film), film_mutex_(control.film_mutex ? *control.film_mutex : own_mutex_) {}

    /// Calls `write_pixels` while no thread copies the film.
    template <class Write>
    void write(const Write& write_pixels) {
        if (!control_.snapshot_requested) return write_pixels();
        const std::shared_lock lock(film_mutex_);
        write_pixels();
    }
    /// If a snapshot is requested, passes a copy of the film to the callback, or null if there is not enough memory.
    void deliver_if_requested() {
        if (!control_.snapshot_requested || !control_.snapshot_requested->exchange(false)) return;
        const std::lock_guard one_at_a_time(delivery_mutex_);
        std::optional<Film> film;
        try {
            film.emplace(copy());
        } catch (const std::bad_alloc&) {  // rendering continues without the snapshot
        }
        control_.snapshot(film ? &*film : nullptr);
    }

private:
    Film copy() {
        const std::unique_lock lock(film_mutex_);
        return film_;
    }
    const RunControl& control_;
    const Film& film_;
    std::shared_mutex own_mutex_;    ///< Used if the caller supplies none.
    std::shared_mutex& film_mutex_;  ///< Shared by the threads that write pixels; exclusive for the copy.
    std::mutex delivery_mutex_;     ///< Held while the callback runs, so that it runs on one thread at a time.
};

}  // namespace kagero

/// Snapshots of the film while threads write to it.
#pragma once

#include "render/run_report.h"

#include <mutex>
#include <new>
#include <optional>
#include <shared_mutex>

namespace kagero {

/// Protects the film for snapshots. Threads write pixels concurrently. The thread that finds a request for a snapshot
/// locks out the writers while it copies the film.
class Snapshots {
public:
    Snapshots(const RunControl& control, const Film& film) : control_(control), film_(film) {}

    /// Calls `pixels`, which writes pixels, while no snapshot is copied.
    template <class Write>
    void write(const Write& pixels) {
        if (!control_.snapshot_requested) return pixels();
        const std::shared_lock lock(writing_);
        pixels();
    }
    /// If a snapshot is requested, passes a copy of the film to the callback, or null if there is not enough memory.
    void deliver_if_requested() {
        if (!control_.snapshot_requested || !control_.snapshot_requested->exchange(false)) return;
        const std::lock_guard one_at_a_time(delivering_);
        std::optional<Film> film;
        try {
            film.emplace(copy());
        } catch (const std::bad_alloc&) {  // rendering continues without the snapshot
        }
        control_.snapshot(film ? &*film : nullptr);
    }

private:
    Film copy() {
        const std::unique_lock lock(writing_);
        return film_;
    }
    const RunControl& control_;
    const Film& film_;
    std::shared_mutex writing_;
    std::mutex delivering_;
};

}  // namespace kagero

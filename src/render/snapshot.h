/// The picture so far, while threads write to it.
#pragma once

#include "render/run_report.h"

#include <mutex>
#include <new>
#include <optional>
#include <shared_mutex>

namespace kagero {

/// Threads write pixels side by side; whoever finds that a snapshot is wanted waits for those now writing and copies
/// the film.
class Snapshots {
public:
    Snapshots(const Watch& watch, const Film& film) : watch_(watch), film_(film) {}

    template <class Write>
    void write(const Write& pixels) {
        if (!watch_.snapshot_wanted) return pixels();
        const std::shared_lock lock(writing_);
        pixels();
    }
    /// Hands a copy of the film on, if one is wanted; nothing where there is no memory for one.
    void take() {
        if (!watch_.snapshot_wanted || !watch_.snapshot_wanted->exchange(false)) return;
        const std::lock_guard one_at_a_time(taking_);
        std::optional<Film> film;
        try {
            film.emplace(copy());
        } catch (const std::bad_alloc&) {  // no reason to end the work
        }
        watch_.snapshot(film ? &*film : nullptr);
    }

private:
    Film copy() {
        const std::unique_lock lock(writing_);
        return film_;
    }
    const Watch& watch_;
    const Film& film_;
    std::shared_mutex writing_;
    std::mutex taking_;
};

}  // namespace kagero

/// The callbacks and limits of a run, and the report that it returns.
#pragma once

#include "film/film.h"
#include "plan/options.h"
#include "render/percentiles.h"
#include "render/recording.h"

#include <array>
#include <atomic>
#include <functional>
#include <limits>

namespace kagero {

/// The time that one thread spent on a run, in seconds.
struct ThreadTime {
    double busy = 0;          ///< Time for processing tiles.
    double finished = 0;      ///< Time when the thread finished its last tile, since the run began.
    std::uint64_t tiles = 0;  ///< Number of tiles that the thread finished.
};

/// The measurements of a run.
struct RunReport {
    std::uint64_t rays = 0;      ///< Number of rays in finished tiles.
    double seconds = 0;          ///< Time of the whole run.
    double predict_seconds = 0;  ///< Time before tracing: division into tiles and prediction of their costs.
    Schedule schedule = Schedule::tiles;
    std::vector<ThreadTime> threads;
    Counters counters{};
    std::array<std::uint64_t, failure_count> failures{};  ///< Number of rays for each value of Failure.
    Percentiles energy_error = percentiles_of({});  ///< Requires Options::energy_error or the layer `energy_error`.
    bool interrupted = false;                       ///< True if some tiles were not finished.
    bool out_of_time = false;                       ///< True if the time limit is the reason for this.
};

/// Called from time to time, from one thread at a time, with the finished share in [0, 1] and the elapsed seconds.
using Progress = std::function<void(double done, double seconds)>;

/// The callbacks of a run, and the conditions that cancel it. Tiles in progress may then continue for half a second, or
/// for half the time limit if that is shorter.
struct RunControl {
    Progress progress = {};
    const std::atomic<bool>* stop = nullptr;  ///< The caller sets it to cancel the run; may be null.
    double time_limit = std::numeric_limits<double>::infinity();  ///< Seconds of tracing and shading.
    Recording* recording = nullptr;                               ///< Receives measurements of every tile; may be null.
    /// The caller sets this flag to request a snapshot. A thread of the run resets it and calls `snapshot`. May be
    /// null.
    std::atomic<bool>* snapshot_requested = nullptr;
    /// Receives a copy of the film while the other threads continue; null if there was not enough memory for the copy.
    std::function<void(const Film*)> snapshot = {};
};

}  // namespace kagero

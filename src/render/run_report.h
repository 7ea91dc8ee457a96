/// How a run is watched from outside, and what it reports when it is finished.
#pragma once

#include "film/film.h"
#include "plan/options.h"
#include "render/recording.h"
#include "render/spread.h"

#include <atomic>
#include <functional>
#include <limits>

namespace kagero {

/// How one thread spent a run, in seconds.
struct ThreadTime {
    double busy = 0;
    double finished = 0;  ///< when its last tile was done, since the run began
    std::uint64_t tiles = 0;
};

/// The result of a finished run.
struct RunReport {
    std::uint64_t rays = 0;
    double seconds = 0;  ///< tracing and shading, prediction included
    double predict_seconds = 0;
    Schedule schedule = Schedule::tiles;
    std::vector<ThreadTime> threads;
    Counters counters{};
    Spread energy_error = spread_of({});  ///< only with Options::energy_error, or its layer
    bool interrupted = false;  ///< some pixels were never traced
    bool out_of_time = false;  ///< … because the time was up
};

/// Called now and then, from one thread at a time, with the finished share in 0…1 and the seconds gone by.
using Progress = std::function<void(double done, double seconds)>;

/// How a run is watched from outside, and what ends it early: after the tiles now running, but for those that take much
/// longer.
struct Watch {
    Progress progress = {};
    const std::atomic<bool>* stop = nullptr;
    double time_limit = std::numeric_limits<double>::infinity();  ///< seconds of tracing and shading
    Recording* recording = nullptr;                               ///< filled in, if wanted
    std::atomic<bool>* snapshot_wanted =
        nullptr;  ///< set from outside; the thread that takes it back hands the film so far to
    std::function<void(const Film*)> snapshot =
        {};  ///< … this, a copy, while the others go on; null: there was no memory for it
};

}  // namespace kagero

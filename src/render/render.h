/// Runs a plan: tiles over threads, rays to pixels, counters to a report.
#pragma once

#include "film/film.h"
#include "render/recording.h"
#include "render/schedule.h"
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

/// What a finished run says of itself.
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

/// How a run is watched from outside, and what ends it early: after the tiles now running, but for those that take much longer.
struct Watch {
    Progress progress = {};
    const std::atomic<bool>* stop = nullptr;
    double time_limit = std::numeric_limits<double>::infinity();  ///< seconds of tracing and shading
    Recording* recording = nullptr;                               ///< filled in, if wanted
    std::atomic<bool>* snapshot_wanted = nullptr;    ///< set from outside; the thread that takes it back hands the film so far to
    std::function<void(const Film*)> snapshot = {};  ///< … this, a copy, while the others go on; null: there was no memory for it
};

/// The pixels that are asked for: the crop, or the whole film.
Tile shown_part(const Plan& plan);

/// A film of those, with the scene's layers. Throws RunError where there is no memory for it.
Film film_of(const Plan& plan);

/// Renders into a film of that size. Where the work is ended early the rest of the film stays as it is.
RunReport render(const Plan& plan, Film& film, const Watch& watch = {});

/// One ray as given to `trace`: start and direction dq/dλ in scene coordinates.
struct RayInput {
    Double3 position, direction;
};

/// Canonical states for rays; with `observer` not empty the direction is read in that observer's rest frame. For those of a falling one the
/// plan must have been made (Options::observer).
std::vector<RayStart> start_rays(const Plan& plan, const std::vector<RayInput>& rays, const std::string& observer);

/// Follows single rays; ends[i] belongs to starts[i]. Positions in `ends` are scene coordinates. Rays that an early end leaves out have
/// `failed` as untraced.
RunReport trace(const Plan& plan, const std::vector<RayStart>& starts, std::vector<RayEnd>& ends, const Watch& watch = {});

/// Every step of every ray, in order of ray and step, in scene coordinates.
std::vector<PathPoint> trace_paths(const Plan& plan, const std::vector<RayStart>& starts, std::vector<RayEnd>& ends, const Watch& watch = {});

/// The canonical state of the ray through the middle of a pixel.
RayStart pixel_ray(const Plan& plan, std::uint32_t x, std::uint32_t y);
/// The same for any point of the film, in pixels from its upper left corner.
RayStart film_ray(const Plan& plan, double x, double y);

}  // namespace kagero

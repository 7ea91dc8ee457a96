/// The callbacks and limits of a run, and the report that it returns.
#pragma once

#include "film/film.h"
#include "paths/trace_paths.h"
#include "plan/options.h"
#include "render/percentiles.h"
#include "render/recording.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <functional>
#include <limits>
#include <optional>
#include <shared_mutex>
#include <string>

namespace kagero {

/// The time that one thread spent on a run, in seconds.
struct ThreadTime {
    double busy = 0;          ///< Time for processing tiles.
    double finished = 0;      ///< Time when the thread finished its last tile, since the run began.
    std::uint64_t tiles = 0;  ///< Number of tiles that the thread finished.
};

/// The work of one process of a run with --mpi.
struct RankTime {
    std::string host;  ///< Name of its machine.
    std::uint32_t threads = 0;
    std::uint64_t tiles = 0;  ///< Number of tiles that it finished.
    double seconds = 0;       ///< Time from the begin of its run to the end of its last tile.
    double busy = 0;          ///< Sum over its threads of the time for processing tiles.
};

/// The numbers of surfaces that have sent the rays of a run on.
struct PathLengths {
    std::uint64_t bounces = 0;   ///< Sum over all rays.
    std::uint32_t greatest = 0;  ///< Maximum over all rays.
    std::uint64_t cut_off = 0;   ///< Number of paths that were cut off.

    void add(std::uint32_t path_bounces, bool is_cut_off) {
        bounces += path_bounces;
        greatest = std::max(greatest, path_bounces);
        cut_off += is_cut_off;
    }
    void add(const PathLengths& other) {
        bounces += other.bounces;
        greatest = std::max(greatest, other.greatest);
        cut_off += other.cut_off;
    }
};

/// The measurements of one tile.
struct TileReport {
    std::uint64_t rays = 0;
    Counters counters{};
    PathLengths path_lengths;
    std::vector<GenerationCount> generations;
    std::array<std::uint64_t, failure_count> failures{};
    ValueCounts energy_errors;  ///< Empty if the run does not measure the error of H.
    std::uint64_t pixels = 0, interpolated_pixels = 0;  ///< 0 if the rays of all pixels are traced.
    ValueCounts interpolation_errors;                   ///< Estimated errors of interpolated pixels, in pixels.
};

/// The measurements of a run.
struct RunReport {
    std::uint64_t rays = 0;      ///< Number of rays in finished tiles.
    double seconds = 0;          ///< Time of the whole run.
    double predict_seconds = 0;  ///< Time before tracing: division into tiles and prediction of their costs.
    Schedule schedule = Schedule::tiles;
    std::vector<ThreadTime> threads;
    std::vector<RankTime> ranks;  ///< One for each rank; empty without --mpi.
    Counters counters{};
    PathLengths path_lengths;
    std::vector<GenerationCount> generations;             ///< Empty if no ray can continue at a surface.
    std::array<std::uint64_t, failure_count> failures{};  ///< Number of rays for each value of Failure.
    Percentiles energy_error = percentiles_of({});  ///< Requires Options::energy_error or the layer `energy_error`.
    /// Number of pixels, and of those whose ray ends are interpolated; 0 if the rays of all pixels are traced.
    std::uint64_t pixels = 0, interpolated_pixels = 0;
    Percentiles interpolation_error = percentiles_of({});  ///< Estimated errors of these ray ends, in pixels.
    std::uint64_t earlier_rays = 0;  ///< Number of these rays that were not traced by this run, but read from a file.
    bool interrupted = false;                       ///< True if some tiles were not finished.
    bool out_of_time = false;                       ///< True if the time limit is the reason for this.
};

/// The numbers of Counters as an array.
using CounterNumbers = std::array<std::uint64_t, sizeof(Counters) / sizeof(std::uint64_t)>;

/// Applies an operation to each pair of numbers of two counters.
template <class Operation>
Counters combine(const Counters& a, const Counters& b, Operation operation) {
    CounterNumbers left = std::bit_cast<CounterNumbers>(a);
    const CounterNumbers right = std::bit_cast<CounterNumbers>(b);
    std::transform(left.begin(), left.end(), right.begin(), left.begin(), operation);
    return std::bit_cast<Counters>(left);
}

/// The sums of several reports. They do not depend on the order in which reports are added.
struct RunTotals {
    TileReport sums;  ///< The errors in it are not used.
    PercentileHistogram energy_errors, interpolation_errors;

    void add(const TileReport& report);
    /// Replaces the rays, counters, path lengths, failures and energy errors of a report by the sums.
    void write_to(RunReport& report) const;
};

/// Called from time to time, from one thread at a time, with the finished share in [0, 1] and the elapsed seconds.
using Progress = std::function<void(double done, double seconds)>;

/// Receives a tile whose pixels are complete. It is called from several threads at once, for different tiles.
using TileFinished = std::function<void(const Tile&, TileReport)>;
/// Receives a tile with a film that contains nothing but its pixels.
using TileFilmFinished = std::function<void(const Tile&, TileReport, const Film&)>;

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
    /// Locked exclusively while the film is copied for a snapshot. Writers of the film outside the run lock it shared.
    /// May be null if there are none.
    std::shared_mutex* film_mutex = nullptr;
    /// Selects the tiles of a picture that are rendered. Empty: all tiles are rendered.
    std::function<bool(const Tile&)> selects_tile = {};
    /// May be empty. Otherwise it is called when all selected tiles are taken, and returns a further tile of the
    /// picture for the run, or nothing if there are no more. It may wait. It is called from several threads at once.
    std::function<std::optional<Tile>()> further_tile = {};
    /// May be empty. Otherwise it receives the measurements of all tiles, and the report of the run contains no sums of
    /// them. If it throws, the run ends with this exception.
    TileFinished tile_finished = {};
    /// May be empty. Otherwise render() calls it instead of `tile_finished`, and renders each tile into a film of its
    /// own.
    TileFilmFinished tile_film_finished = {};
};

}  // namespace kagero

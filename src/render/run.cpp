#include "render/run.h"

#include "adaptive/sample_tile.h"
#include "kernels/assertion.h"
#include "render/threads.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <mutex>
#include <optional>

#include <time.h>
#include <x86intrin.h>

namespace kagero {
namespace {

/// Buffers and results of one thread, aligned so that no two threads use the same cache line.
struct alignas(64) ThreadData {
    TracedRays traced;
    AdaptiveSamples samples;  ///< Used only if the run interpolates ray ends.
    PathCounters counters;
    PathLengths path_lengths;
    ThreadTime time;
    std::uint64_t rays = 0;
    std::array<std::uint64_t, failure_count> failures{};
    PercentileHistogram energy_errors;
    ValueCounter tile_errors;  ///< Energy errors of the tile in progress, if tiles have reports.
    std::uint64_t pixels = 0, interpolated_pixels = 0;
    ValueCounter tile_interpolation_errors;
    PercentileHistogram interpolation_errors;
};

double processor_seconds() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

GenerationCount difference(const GenerationCount& a, const GenerationCount& b) {
    return {a.rays - b.rays, a.active_lane_steps - b.active_lane_steps, a.issued_lane_steps - b.issued_lane_steps,
            a.nanoseconds - b.nanoseconds};
}

/// Returns a report with the sums of rays and counters and the energy errors of all threads.
RunReport merge_results(std::vector<ThreadData>& threads) {
    RunTotals totals;
    RunReport report;
    for (const ThreadData& data : threads) {
        totals.add({data.rays,
                    data.counters.total,
                    data.path_lengths,
                    data.counters.generations,
                    data.failures,
                    {},
                    data.pixels,
                    data.interpolated_pixels,
                    {}});
        totals.energy_errors.add(data.energy_errors);
        totals.interpolation_errors.add(data.interpolation_errors);
        report.threads.push_back(data.time);
    }
    totals.write_to(report);
    return report;
}

/// The execution of a list of tiles by several threads.
class Run {
public:
    Run(const Plan& plan, const Job& job, const WorkList& work, const TileRays& rays, const TileDone& done,
        const RunControl& control, BranchChoice choice, double interpolation_bound)
        : plan_(plan), job_(job), work_(work), rays_(rays), done_(done), control_(control), choice_(choice),
          interpolation_bound_(interpolation_bound) {
        for (std::size_t i = 0; i < work.tiles.size(); ++i) total_cost_ += cost(i);
        if (control.recording) control.recording->tiles.assign(work.tiles.size(), TileRecord{});
    }

    /// Processes tiles as thread number `thread` until all are taken or the run is cancelled. If one thread throws, the
    /// others take no further tiles.
    void process_tiles(unsigned thread, ThreadData& data) try {
        for (std::size_t i = next_++; i < work_.tiles.size(); i = next_++)
            if (!take(data, cost(i), [&] { return process(i, thread, data); })) return;
        while (control_.further_tile && !is_cut_off_) {
            const std::optional<Tile> tile = control_.further_tile();
            if (!tile || !take(data, 0, [&] { return trace_and_finish(*tile, data, nullptr); })) return;
        }
    } catch (...) {
        next_ = work_.tiles.size();
        is_cut_off_ = true;
        throw;
    }
    double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count(); }
    bool complete() const { return !is_cut_off_; }
    bool out_of_time() const { return out_of_time_ && !complete(); }

private:
    /// Interval of the tiles in which ticks are counted. Reading the time-stamp counter adds a few per cent to the time
    /// of a tile.
    static constexpr std::size_t tick_count_interval = 4;

    /// Returns the time, in seconds, for which tiles in progress may continue after the run is cancelled.
    double grace_period() const { return std::min(0.5, 0.5 * control_.time_limit); }

    /// The state of one tile's cancel token. The tile is cancelled when the grace period of a cancelled run is over.
    struct TileCancellation {
        Run& run;
        bool cancelled = false;
        /// Sets `cancelled` and returns it.
        bool update() {
            return cancelled = cancelled || (run.cancelled() && run.seconds() > run.cancelled_at_ + run.grace_period());
        }
    };

    double cost(std::size_t i) const { return work_.costs.empty() ? 1 : work_.costs[i]; }

    /// Returns true if the run is cancelled. Stores in `cancelled_at_` the earliest time at which a thread found this.
    bool cancelled() {
        const double now = seconds();
        if (now > control_.time_limit) out_of_time_ = true;
        if (!out_of_time_ && !(control_.stop && control_.stop->load(std::memory_order_relaxed))) return false;
        for (double earliest = cancelled_at_; now < earliest && !cancelled_at_.compare_exchange_weak(earliest, now);) {}
        return true;
    }
    /// Calls process(), which processes a tile, unless the run is cancelled. Returns false if the tile is not finished.
    template <class Process>
    bool take(ThreadData& data, double cost, const Process& process) {
        const double begin = seconds();
        if (cancelled() || !process()) {
            is_cut_off_ = true;
            return false;
        }
        data.time.finished = seconds();
        data.time.busy += data.time.finished - begin;
        ++data.time.tiles;
        report_progress(cost);
        return true;
    }
    /// Processes a tile and records its measurements if they are requested. Returns false if the tile was cancelled.
    bool process(std::size_t i, unsigned thread, ThreadData& data) {
        if (!control_.recording) return trace_and_finish(work_.tiles[i], data, nullptr);
        TileRecord& record = control_.recording->tiles[i];
        const Counters counters_before = data.counters.total;
        const double processor_time_before = processor_seconds();
        record.tile = work_.tiles[i];
        record.thread = thread;
        record.predicted = cost(i);
        record.has_tick_counts = (i + control_.recording->round) % tick_count_interval == 0;
        // Processor time is read before `begin` and after `end`, because during its system call the scheduler may
        // switch to another program.
        record.begin = seconds();
        const bool done = trace_and_finish(work_.tiles[i], data, &record);
        record.end = done ? seconds() : 0;
        record.processor_time = processor_seconds() - processor_time_before;
        record.counters = combine(data.counters.total, counters_before, std::minus{});
        return done;
    }
    /// Traces a tile and passes its ray ends to `done_`. Returns false if the tile was cancelled.
    bool trace_and_finish(const Tile& tile, ThreadData& data, TileRecord* record) {
        const PathCounters counters_before = data.counters;
        TileCancellation cancellation{*this};
        const bool interpolates = interpolation_bound_ > 0;
        if (rays_ && !interpolates) rays_(tile, data.traced.list);
        if (record) {
            record->listed = rays_ ? seconds() : record->begin;
            record->ticks = __rdtsc();
        }
        Job job = job_;
        job.timed = record && record->has_tick_counts;
        const CancelToken cancel{[](void* user) { return static_cast<TileCancellation*>(user)->update(); },
                                 &cancellation};
        if (interpolates)
            sample_tile(plan_, job, tile, interpolation_bound_, data.traced, data.samples, data.counters.total, cancel);
        else trace_paths(plan_, job, tile, choice_, data.traced, data.counters, cancel);
        if (record) {
            record->traced = seconds();
            record->ticks = __rdtsc() - record->ticks;
        }
        if (!cancellation.cancelled) done_(tile, data.traced, cancel);
        if (cancellation.cancelled) {
            data.counters = counters_before;
            return false;
        }
        const auto failed = static_cast<std::size_t>(Status::failed);
        const bool has_failures = data.counters.total.ended[failed] != counters_before.total.ended[failed];
        if (!control_.tile_finished) {
            count_rays(data, has_failures, data, data.energy_errors);
            data.interpolation_errors.add(count_pixels(data, data));
            return true;
        }
        control_.tile_finished(tile, report_of(data, counters_before, has_failures));
        return true;
    }
    /// Adds the rays of a tile and their failures to `counts`, which is a ThreadData or a TileReport, and their energy
    /// errors to `errors`.
    template <class Counts, class Errors>
    void count_rays(const ThreadData& data, bool has_failures, Counts& counts, Errors& errors) const {
        const TracedRays& traced = data.traced;
        const std::vector<RayEnd>& ends = interpolation_bound_ > 0 ? data.samples.nodes.ends() : traced.ends;
        counts.rays += ends.size();
        for (std::size_t i = 0; i < traced.paths.size(); ++i)
            counts.path_lengths.add(traced.paths[i].bounces, ends[i].cut_off);
        if (has_failures)
            for (const RayEnd& end : ends) ++counts.failures[static_cast<std::size_t>(end.failure)];
        if (!(job_.outputs & output_energy)) return;
        for (const RayEnd& end : ends)  // NaN for a ray that could not start
            if (!std::isnan(end.energy_error)) errors.add(end.energy_error);
    }
    /// Adds the pixels of a tile to `counts`, which is a ThreadData or a TileReport, if the run interpolates ray ends.
    /// Returns the estimated errors of the interpolated pixels.
    template <class Counts>
    ValueCounts count_pixels(ThreadData& data, Counts& counts) const {
        if (!(interpolation_bound_ > 0)) return {};
        counts.pixels += data.traced.ends.size();
        for (const auto& [pixels, error] : data.samples.interpolated) {
            counts.interpolated_pixels += pixels;
            if (pixels > 0) data.tile_interpolation_errors.add(error, pixels);
        }
        return data.tile_interpolation_errors.take();
    }
    /// Returns the report of the tile that the thread has just traced. `before` contains its counters before the tile.
    TileReport report_of(ThreadData& data, const PathCounters& before, bool has_failures) const {
        TileReport report;
        report.counters = combine(data.counters.total, before.total, std::minus{});
        report.generations = data.counters.generations;
        for (std::size_t i = 0; i < before.generations.size(); ++i)
            report.generations[i] = difference(report.generations[i], before.generations[i]);
        count_rays(data, has_failures, report, data.tile_errors);
        report.energy_errors = data.tile_errors.take();
        report.interpolation_errors = count_pixels(data, report);
        return report;
    }
    /// Adds the cost of a finished tile, and calls the progress callback unless another thread is calling it.
    void report_progress(double cost) {
        finished_cost_ += cost;
        if (!control_.progress) return;
        if (const std::unique_lock lock(progress_mutex_, std::try_to_lock); lock)  // so that it never decreases
            control_.progress(std::min(finished_cost_.load() / total_cost_, 1.0), seconds());
    }

    const Plan& plan_;
    Job job_;
    const WorkList& work_;
    const TileRays& rays_;
    const TileDone& done_;
    const RunControl& control_;
    const BranchChoice choice_;
    const double interpolation_bound_;
    const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
    double total_cost_ = 0;                  ///< Cost of all tiles.
    std::atomic<double> finished_cost_ = 0;  ///< Cost of the finished tiles.
    std::atomic<std::size_t> next_ = 0;      ///< Index of the next tile.
    std::atomic<bool> is_cut_off_ = false;   ///< True if a tile that was taken is not finished.
    std::atomic<bool> out_of_time_ = false;
    /// Time when the run was cancelled, in seconds since it began; infinity if it is not cancelled.
    std::atomic<double> cancelled_at_ = std::numeric_limits<double>::infinity();
    std::mutex progress_mutex_;
};

}  // namespace

RunReport run_tiles(const Plan& plan, const Job& job, const WorkList& work, const TileRays& rays, const TileDone& done,
                    const RunControl& control, BranchChoice choice, double interpolation_bound) {
    std::vector<ThreadData> threads(std::max(plan.run.threads, 1u));
    Run run(plan, job, work, rays, done, control, choice, interpolation_bound);
    run_on_threads(static_cast<unsigned>(threads.size()),
                   [&](unsigned thread) { run.process_tiles(thread, threads[thread]); });
    const double elapsed = run.seconds();
    RunReport report = merge_results(threads);
    report.seconds = elapsed;
    report.interrupted = !run.complete();
    report.out_of_time = run.out_of_time();
    return report;
}

}  // namespace kagero

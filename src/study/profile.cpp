#include "study/profile.h"

#include "accuracy/end_errors.h"
#include "accuracy/timing.h"
#include "plan/names.h"
#include "render/operation_count.h"
#include "study/peak.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

namespace kagero {
namespace {

/// Limits of the number of rounds if it is not stated.
constexpr unsigned min_rounds = 3, max_rounds = 50;
/// Total time of the rounds if their number is not stated, seconds.
constexpr double total_time = 20;

/// A configuration of the render, with the results of its runs.
struct RenderSetup {
    unsigned threads;
    Schedule schedule;
    bool recorded = false;        ///< True if the runs record measurements of each tile.
    RunReport fastest{};          ///< Report of the fastest run.
    Recording recording{};        ///< Tiles of the fastest run, each with its shortest time over all runs.
    std::vector<double> times{};  ///< Seconds of each run.
    double seconds() const { return fastest.seconds; }
};

/// Returns the median over the rounds of the ratio of two times. A temporary disturbance of the machine affects both
/// times of a round.
double median_ratio(const std::vector<double>& over, const std::vector<double>& under) {
    std::vector<double> ratios;
    for (std::size_t i = 0; i < over.size(); ++i) ratios.push_back(over[i] / under[i]);
    return timing_of(std::move(ratios)).median;
}

/// Peak rates of a number of threads, in operations per second, one per round.
struct PeakRates {
    unsigned threads;
    std::vector<double> rates{};
    double best() const { return *std::max_element(rates.begin(), rates.end()); }
};

/// Returns 1, 2, …, `max_threads`. If `max_threads` exceeds 8, returns the powers of two below it, and `max_threads`.
std::vector<unsigned> thread_counts(unsigned max_threads) {
    std::vector<unsigned> counts;
    for (unsigned n = 1; n < max_threads; n = (max_threads > 8) ? 2 * n : n + 1) counts.push_back(n);
    counts.push_back(max_threads);
    return counts;
}

/// Returns the configurations of a round: all schedules on all threads, the plan's schedule last. Then follow the
/// plan's schedule with recording, and the plan's schedule on fewer threads. Runs that are compared are adjacent. Runs
/// with few threads come last, because idle cores need time to reach their clock rate again.
std::vector<RenderSetup> render_setups(unsigned threads, Schedule plan_schedule) {
    std::vector<RenderSetup> setups;
    for (std::size_t i = 0; i < schedule_names().size(); ++i)
        if (static_cast<Schedule>(i) != plan_schedule) setups.push_back({threads, static_cast<Schedule>(i)});
    setups.push_back({threads, plan_schedule});
    setups.push_back({threads, plan_schedule, true});
    for (const unsigned n : thread_counts(threads))
        if (n < threads) setups.push_back({n, plan_schedule});
    return setups;
}

/// Sets the time of each tile to its minimum over all runs, to remove disturbances by other processes. Every run has
/// the same tiles in the same order, because predicted costs do not depend on measured times.
void keep_minimum(const Recording& before, Recording& now) {
    for (std::size_t i = 0; i < before.tiles.size(); ++i)
        now.tiles[i].processor_time = std::min(now.tiles[i].processor_time, before.tiles[i].processor_time);
}

/// Renders the picture once with a configuration. Returns false if the run was interrupted.
bool run(Plan plan, Film& film, RenderSetup& setup, const std::atomic<bool>* stop) {
    plan.run.threads = setup.threads;
    plan.run.schedule = setup.schedule;
    Recording recording;
    RunControl control;
    control.stop = stop;
    recording.round = setup.times.size();
    if (setup.recorded) control.recording = &recording;
    const RunReport report = render_with_errors(plan, film, control);
    if (report.interrupted) return false;
    setup.times.push_back(report.seconds);
    const bool faster = !setup.fastest.rays || report.seconds < setup.fastest.seconds;
    keep_minimum(faster ? setup.recording : recording, faster ? recording : setup.recording);
    if (!faster) return true;
    setup.fastest = report;
    setup.recording = std::move(recording);
    return true;
}

/// Returns the share of the render time during which the thread that finished first is idle at the end.
double idle_at_end(const RunReport& report) {
    double first = std::numeric_limits<double>::infinity();
    for (const ThreadTime& time : report.threads) first = std::min(first, time.finished);
    return 1 - (first + report.predict_seconds) / report.seconds;
}

/// Returns the stage times. The split of the tracing time is extrapolated from the tiles with detailed timers.
StageTimes stages_of(const RunReport& report, const Recording& recording) {
    StageTimes stages;
    stages.predict = report.predict_seconds * double(report.threads.size());
    double tracing = 0, all = 0, query = 0, refine = 0;
    for (const TileRecord& tile : recording.tiles) {
        stages.list += tile.listed - tile.begin;
        tracing += tile.traced - tile.listed;
        stages.shade += tile.end - tile.traced;
        if (!tile.has_tick_counts) continue;
        all += double(tile.ticks);
        query += double(tile.counters.query_ticks);
        refine += double(tile.counters.refinement_ticks);
    }
    if (all > 0) {
        stages.query = tracing * query / all;
        stages.refine = tracing * refine / all;
    }
    stages.integrate = tracing - stages.query - stages.refine;
    return stages;
}

std::optional<double> correlation_of(const Recording& recording) {
    std::vector<double> predicted, measured;
    for (const TileRecord& tile : recording.tiles) {
        predicted.push_back(tile.predicted);
        measured.push_back(tile.processor_time);
    }
    return correlation(predicted, measured);
}

void count_operations(const Plan& plan, Profile& profile) {
    if (plan.scene->straight) return;
    profile.operations = operations_of(plan);
    profile.all_operations = operations_of(plan, profile.report.counters);
}

/// Fills the profile from the results of all configurations.
void summarize(const std::vector<RenderSetup>& setups, const std::vector<PeakRates>& peak_rates, Schedule plan_schedule,
               Profile& profile) {
    const unsigned threads = peak_rates.back().threads;
    const auto setup_with = [&](unsigned n) -> const RenderSetup& {
        return *std::find_if(setups.begin(), setups.end(), [&](const RenderSetup& setup) {
            return setup.threads == n && setup.schedule == plan_schedule && !setup.recorded;
        });
    };
    const RenderSetup &plain = setup_with(threads), &one = setup_with(1);
    profile.plain_seconds = plain.seconds();
    for (const RenderSetup& setup : setups) {
        if (setup.recorded) {
            profile.report = setup.fastest;
            profile.recording = setup.recording;
            profile.recorded_seconds = setup.seconds();
            profile.overhead = median_ratio(setup.times, plain.times) - 1;
            profile.stages = stages_of(setup.fastest, setup.recording);
            if (setup.schedule == Schedule::predicted) profile.correlation = correlation_of(setup.recording);
        } else if (setup.threads == threads) {
            profile.schedules.push_back({setup.schedule, setup.seconds(), idle_at_end(setup.fastest)});
        }
    }
    std::sort(profile.schedules.begin(), profile.schedules.end(),
              [](const ScheduleTime& a, const ScheduleTime& b) { return a.schedule < b.schedule; });
    for (const PeakRates& peak_rate : peak_rates) {
        const RenderSetup& setup = setup_with(peak_rate.threads);
        profile.scaling.push_back({peak_rate.threads, setup.seconds(), median_ratio(one.times, setup.times),
                                   median_ratio(peak_rate.rates, peak_rates.front().rates)});
    }
    profile.peak_of_one = peak_rates.front().best();
    profile.peak_of_all = peak_rates.back().best();
}

}  // namespace

std::optional<double> correlation(const std::vector<double>& a, const std::vector<double>& b) {
    const double n = double(a.size());
    double mean_a = 0, mean_b = 0, aa = 0, bb = 0, ab = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        mean_a += a[i] / n;
        mean_b += b[i] / n;
    }
    for (std::size_t i = 0; i < a.size(); ++i) {
        const double x = a[i] - mean_a, y = b[i] - mean_b;
        aa += x * x;
        bb += y * y;
        ab += x * y;
    }
    const double norm = std::sqrt(aa) * std::sqrt(bb);
    if (!(norm > 0)) return std::nullopt;
    return std::clamp(ab / norm, -1.0, 1.0);
}

Profile profile(const Plan& plan, Film& film, unsigned repeats, const Progress& progress,
                const std::atomic<bool>* stop) {
    const auto begin = std::chrono::steady_clock::now();
    const unsigned threads = plan.run.threads;
    const Schedule plan_schedule = schedule_of(plan);
    std::vector<RenderSetup> setups = render_setups(threads, plan_schedule);
    const Peak peak(plan.module(), plan.run.kernel->precision);
    std::vector<PeakRates> peak_rates;
    for (const unsigned n : thread_counts(threads)) peak_rates.push_back({n});

    Profile result;
    const auto passed = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(); };
    unsigned rounds = repeats ? repeats : min_rounds;
    // The configurations are interleaved, so that a temporary disturbance of the machine affects all of them.
    for (unsigned r = 0; r < rounds; ++r) {
        for (std::size_t i = 0; i < setups.size() && !result.interrupted; ++i) {
            result.interrupted = !run(plan, film, setups[i], stop);
            if (progress) progress(double(r * setups.size() + i + 1) / double(rounds * setups.size()), passed());
        }
        if (result.interrupted) break;
        for (PeakRates& peak_rate : peak_rates)
            peak_rate.rates.push_back(peak.operations_per_second(peak_rate.threads));
        if (r == 0 && !repeats)
            rounds = unsigned(std::clamp(total_time / passed(), double(min_rounds), double(max_rounds)));
    }
    result.repeats = unsigned(setups.back().times.size());
    if (result.repeats == 0) return result;
    for (RenderSetup& setup : setups) setup.times.resize(result.repeats);  // Removes the time of an interrupted round.

    summarize(setups, peak_rates, plan_schedule, result);
    count_operations(plan, result);
    return result;
}

}  // namespace kagero

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

/// Limits of the number of rounds if the caller does not state it.
constexpr unsigned min_rounds = 3, max_rounds = 50;
/// Total time of the rounds in seconds if the caller does not state their number.
constexpr double total_seconds = 20;

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

/// Returns the median over the rounds of the ratio of two measurements. A temporary disturbance of the machine affects
/// both measurements of a round.
double median_ratio(const std::vector<double>& numerators, const std::vector<double>& denominators) {
    std::vector<double> ratios;
    for (std::size_t i = 0; i < numerators.size(); ++i) ratios.push_back(numerators[i] / denominators[i]);
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

/// Returns the configurations of a round: first the other schedules on all threads, then the plan's schedule on all
/// threads, without and with recording, and last the plan's schedule on fewer threads. The runs without and with
/// recording are adjacent, because their times are compared. Runs on fewer threads come last, because idle cores need
/// time to reach their clock rate again.
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

/// Replaces the time of each tile of `kept` by that in `other` if the latter is shorter. This removes disturbances by
/// other processes. Both recordings have the same tiles in the same order, because predicted costs do not depend on
/// measured times. Before the first run, `other` has no tiles.
void keep_minimum(const Recording& other, Recording& kept) {
    for (std::size_t i = 0; i < other.tiles.size(); ++i)
        kept.tiles[i].processor_time = std::min(kept.tiles[i].processor_time, other.tiles[i].processor_time);
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
    const bool is_fastest = !setup.fastest.rays || report.seconds < setup.fastest.seconds;
    keep_minimum(is_fastest ? setup.recording : recording, is_fastest ? recording : setup.recording);
    if (!is_fastest) return true;
    setup.fastest = report;
    setup.recording = std::move(recording);
    return true;
}

/// Returns ScheduleTime::idle_at_end. ThreadTime::finished does not include the prediction of costs.
double idle_at_end(const RunReport& report) {
    double first_finished = std::numeric_limits<double>::infinity();
    for (const ThreadTime& time : report.threads) first_finished = std::min(first_finished, time.finished);
    return 1 - (first_finished + report.predict_seconds) / report.seconds;
}

/// Returns the stage times. Queries and refinement are timed only in the tiles with tick counts; their shares of the
/// ticks of these tiles are applied to the tracing time of all tiles.
StageTimes stages_of(const RunReport& report, const Recording& recording) {
    StageTimes stages;
    stages.predict = report.predict_seconds * double(report.threads.size());
    double tracing = 0, ticks = 0, query_ticks = 0, refinement_ticks = 0;
    for (const TileRecord& tile : recording.tiles) {
        stages.list += tile.listed - tile.begin;
        tracing += tile.traced - tile.listed;
        stages.shade += tile.end - tile.traced;
        if (!tile.has_tick_counts) continue;
        ticks += double(tile.ticks);
        query_ticks += double(tile.counters.query_ticks);
        refinement_ticks += double(tile.counters.refinement_ticks);
    }
    if (ticks > 0) {
        stages.query = tracing * query_ticks / ticks;
        stages.refine = tracing * refinement_ticks / ticks;
    }
    stages.integrate = tracing - stages.query - stages.refine;
    return stages;
}

/// Returns the correlation of predicted and measured tile costs.
std::optional<double> correlation_of(const Recording& recording) {
    std::vector<double> predicted, measured;
    for (const TileRecord& tile : recording.tiles) {
        predicted.push_back(tile.predicted);
        measured.push_back(tile.processor_time);
    }
    return correlation(predicted, measured);
}

/// Sets the operation counts of the profile. They stay zero if rays are straight.
void count_operations(const Plan& plan, Profile& profile) {
    if (plan.scene->straight) return;
    profile.operations = operations_of(plan);
    profile.total_operations = operations_of(plan, profile.report.counters);
}

/// Fills the profile from the results of all configurations.
void summarize(const std::vector<RenderSetup>& setups, const std::vector<PeakRates>& peak_rates, Schedule plan_schedule,
               Profile& profile) {
    const unsigned threads = peak_rates.back().threads;
    // Returns the configuration with the plan's schedule on n threads, without recording.
    const auto setup_with = [&](unsigned n) -> const RenderSetup& {
        return *std::find_if(setups.begin(), setups.end(), [&](const RenderSetup& setup) {
            return setup.threads == n && setup.schedule == plan_schedule && !setup.recorded;
        });
    };
    const RenderSetup &plain = setup_with(threads), &on_one_thread = setup_with(1);
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
        profile.scaling.push_back({peak_rate.threads, setup.seconds(), median_ratio(on_one_thread.times, setup.times),
                                   median_ratio(peak_rate.rates, peak_rates.front().rates)});
    }
    profile.one_thread_peak = peak_rates.front().best();
    profile.all_threads_peak = peak_rates.back().best();
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
        const double deviation_a = a[i] - mean_a, deviation_b = b[i] - mean_b;
        aa += deviation_a * deviation_a;
        bb += deviation_b * deviation_b;
        ab += deviation_a * deviation_b;
    }
    const double norm = std::sqrt(aa) * std::sqrt(bb);
    if (!(norm > 0)) return std::nullopt;
    return std::clamp(ab / norm, -1.0, 1.0);
}

Profile profile(const Plan& plan, Film& film, unsigned rounds, const Progress& progress,
                const std::atomic<bool>* stop) {
    const auto begin = std::chrono::steady_clock::now();
    const unsigned threads = plan.run.threads;
    const Schedule plan_schedule = schedule_of(plan);
    std::vector<RenderSetup> setups = render_setups(threads, plan_schedule);
    const Peak peak(plan.module(), plan.run.kernel->precision);
    std::vector<PeakRates> peak_rates;
    for (const unsigned n : thread_counts(threads)) peak_rates.push_back({n});

    Profile result;
    const auto elapsed = [begin] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    };
    const bool chooses_rounds = rounds == 0;
    if (chooses_rounds) rounds = min_rounds;  // The first round determines the number of rounds.
    // The configurations are interleaved, so that a temporary disturbance of the machine affects all of them.
    for (unsigned r = 0; r < rounds; ++r) {
        for (std::size_t i = 0; i < setups.size() && !result.interrupted; ++i) {
            result.interrupted = !run(plan, film, setups[i], stop);
            if (progress) progress(double(r * setups.size() + i + 1) / double(rounds * setups.size()), elapsed());
        }
        if (result.interrupted) break;
        for (PeakRates& peak_rate : peak_rates)
            peak_rate.rates.push_back(peak.operations_per_second(peak_rate.threads));
        if (r == 0 && chooses_rounds)
            rounds = unsigned(std::clamp(total_seconds / elapsed(), double(min_rounds), double(max_rounds)));
    }
    result.rounds = unsigned(setups.back().times.size());
    if (result.rounds == 0) return result;
    for (RenderSetup& setup : setups) setup.times.resize(result.rounds);  // Removes the time of an interrupted round.

    summarize(setups, peak_rates, plan_schedule, result);
    count_operations(plan, result);
    return result;
}

}  // namespace kagero

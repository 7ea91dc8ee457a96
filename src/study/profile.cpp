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

constexpr unsigned least_profiled = 3, most_profiled = 50;  // rounds
constexpr double enough_profiled = 20;  // seconds

/// One way of rendering the same picture, its runs' times, and the quickest of them.
struct Way {
    unsigned threads;
    Schedule schedule;
    bool recorded = false;
    RunReport best{};
    Recording recording{};
    std::vector<double> times{};
    double seconds() const { return best.seconds; }
};

/// The median of ratios by rounds: what slows the machine for a while slows both.
double median_ratio(const std::vector<double>& over, const std::vector<double>& under) {
    std::vector<double> ratios;
    for (std::size_t i = 0; i < over.size(); ++i) ratios.push_back(over[i] / under[i]);
    return timing_of(std::move(ratios)).median;
}

/// How fast multiply-adds alone run on so many threads, by rounds.
struct Roof {
    unsigned threads;
    std::vector<double> rates{};
    double best() const { return *std::max_element(rates.begin(), rates.end()); }
};

/// 1 … N, or its powers of two and N where that is many.
std::vector<unsigned> thread_counts(unsigned most) {
    std::vector<unsigned> counts;
    for (unsigned n = 1; n < most; n = (most > 8) ? 2 * n : n + 1) counts.push_back(n);
    counts.push_back(most);
    return counts;
}

/// Every schedule on all threads, the plan's own last; that with a recording, and on fewer threads. What is compared
/// stands close together, and behind runs of as many threads: after those of fewer a core needs a while to wake up.
std::vector<Way> ways_of(unsigned threads, Schedule own) {
    std::vector<Way> ways;
    for (std::size_t i = 0; i < schedule_names().size(); ++i)
        if (static_cast<Schedule>(i) != own) ways.push_back({threads, static_cast<Schedule>(i)});
    ways.push_back({threads, own});
    ways.push_back({threads, own, true});
    for (const unsigned n : thread_counts(threads))
        if (n < threads) ways.push_back({n, own});
    return ways;
}

/// A tile costs the least that it took in any run: what else the machine did is not its cost. Every run hands out the
/// same tiles in the same order, as nothing is predicted by the clock.
void keep_least(const Recording& before, Recording& now) {
    for (std::size_t i = 0; i < before.tiles.size(); ++i)
        now.tiles[i].processor = std::min(now.tiles[i].processor, before.tiles[i].processor);
}

bool run(Plan plan, Film& film, Way& way, const std::atomic<bool>* stop) {
    plan.run.threads = way.threads;
    plan.run.schedule = way.schedule;
    Recording recording;
    Watch watch;
    watch.stop = stop;
    recording.round = way.times.size();
    if (way.recorded) watch.recording = &recording;
    const RunReport report = render_with_errors(plan, film, watch);
    if (report.interrupted) return false;
    way.times.push_back(report.seconds);
    const bool quicker = !way.best.rays || report.seconds < way.best.seconds;
    keep_least(quicker ? way.recording : recording, quicker ? recording : way.recording);
    if (!quicker) return true;
    way.best = report;
    way.recording = std::move(recording);
    return true;
}

double idle_at_end(const RunReport& report) {
    double first = std::numeric_limits<double>::infinity();
    for (const ThreadTime& time : report.threads) first = std::min(first, time.finished);
    return 1 - (first + report.predict_seconds) / report.seconds;
}

StageTimes stages_of(const RunReport& report, const Recording& recording) {
    StageTimes stages;
    stages.predict = report.predict_seconds * double(report.threads.size());
    double tracing = 0, all = 0, query = 0, refine = 0;
    for (const TileRecord& tile : recording.tiles) {
        stages.list += tile.listed - tile.begin;
        tracing += tile.traced - tile.listed;
        stages.shade += tile.end - tile.traced;
        if (!tile.looked_into) continue;
        all += double(tile.ticks), query += double(tile.counters.query_ticks),
            refine += double(tile.counters.landing_ticks);
    }
    if (all > 0) stages.query = tracing * query / all, stages.refine = tracing * refine / all;
    stages.integrate = tracing - stages.query - stages.refine;
    return stages;
}

std::optional<double> correlation_of(const Recording& recording) {
    std::vector<double> predicted, measured;
    for (const TileRecord& tile : recording.tiles)
        predicted.push_back(tile.predicted), measured.push_back(tile.processor);
    return correlation(predicted, measured);
}

void count_operations(const Plan& plan, Profile& profile) {
    if (plan.scene->straight) return;
    profile.operations = operations_of(plan);
    profile.all_operations = operations_of(plan, profile.report.counters);
}

void summarize(const std::vector<Way>& ways, const std::vector<Roof>& roofs, Schedule own, Profile& profile) {
    const unsigned threads = roofs.back().threads;
    const auto way_of = [&](unsigned n) -> const Way& {
        return *std::find_if(ways.begin(), ways.end(),
                             [&](const Way& way) { return way.threads == n && way.schedule == own && !way.recorded; });
    };
    const Way &plain = way_of(threads), &one = way_of(1);
    profile.plain_seconds = plain.seconds();
    for (const Way& way : ways) {
        if (way.recorded) {
            profile.report = way.best, profile.recording = way.recording, profile.recorded_seconds = way.seconds();
            profile.overhead = median_ratio(way.times, plain.times) - 1;
            profile.stages = stages_of(way.best, way.recording);
            if (way.schedule == Schedule::predicted) profile.correlation = correlation_of(way.recording);
        } else if (way.threads == threads) {
            profile.schedules.push_back({way.schedule, way.seconds(), idle_at_end(way.best)});
        }
    }
    std::sort(profile.schedules.begin(), profile.schedules.end(),
              [](const ScheduleTime& a, const ScheduleTime& b) { return a.schedule < b.schedule; });
    for (const Roof& roof : roofs) {
        const Way& way = way_of(roof.threads);
        profile.scaling.push_back({roof.threads, way.seconds(), median_ratio(one.times, way.times),
                                   median_ratio(roof.rates, roofs.front().rates)});
    }
    profile.peak_of_one = roofs.front().best(), profile.peak_of_all = roofs.back().best();
}

}  // namespace

std::optional<double> correlation(const std::vector<double>& a, const std::vector<double>& b) {
    const double n = double(a.size());
    double mean_a = 0, mean_b = 0, aa = 0, bb = 0, ab = 0;
    for (std::size_t i = 0; i < a.size(); ++i) mean_a += a[i] / n, mean_b += b[i] / n;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const double x = a[i] - mean_a, y = b[i] - mean_b;
        aa += x * x, bb += y * y, ab += x * y;
    }
    const double size = std::sqrt(aa) * std::sqrt(bb);
    if (!(size > 0)) return std::nullopt;
    return std::clamp(ab / size, -1.0, 1.0);
}

Profile profile(const Plan& plan, Film& film, unsigned repeats, const Progress& progress,
                const std::atomic<bool>* stop) {
    const auto begin = std::chrono::steady_clock::now();
    const unsigned threads = plan.run.threads;
    const Schedule own = schedule_of(plan);
    std::vector<Way> ways = ways_of(threads, own);
    const Peak peak(plan.module(), plan.run.kernel->precision);
    std::vector<Roof> roofs;
    for (const unsigned n : thread_counts(threads)) roofs.push_back({n});

    Profile result;
    const auto passed = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(); };
    unsigned rounds = repeats ? repeats : least_profiled;
    // Interleaved, so that a slow minute of the machine is nobody's alone.
    for (unsigned r = 0; r < rounds; ++r) {
        for (std::size_t i = 0; i < ways.size() && !result.interrupted; ++i) {
            result.interrupted = !run(plan, film, ways[i], stop);
            if (progress) progress(double(r * ways.size() + i + 1) / double(rounds * ways.size()), passed());
        }
        if (result.interrupted) break;
        for (Roof& roof : roofs) roof.rates.push_back(peak.operations_per_second(roof.threads));
        if (r == 0 && !repeats)
            rounds = unsigned(std::clamp(enough_profiled / passed(), double(least_profiled), double(most_profiled)));
    }
    result.repeats = unsigned(ways.back().times.size());
    if (result.repeats == 0) return result;
    for (Way& way : ways) way.times.resize(result.repeats);  // of an interrupted round some had begun

    summarize(ways, roofs, own, result);
    count_operations(plan, result);
    return result;
}

}  // namespace kagero

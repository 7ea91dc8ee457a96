/// Profile of a render: times of its stages, schedules and thread counts, from repeated renders of the same picture.
#pragma once

#include "render/render.h"

#include <optional>

namespace kagero {

/// Times of the stages in seconds, summed over threads.
struct StageTimes {
    double predict = 0;    ///< Prediction of tile costs: its duration times the number of threads.
    double list = 0;       ///< Generation of ray starts, if the kernel does not generate them.
    double integrate = 0;  ///< Tracing loop without queries and refinement.
    double query = 0;      ///< Embree queries, including the chords of the steps.
    double refine = 0;     ///< Refinement of events.
    double shade = 0;      ///< Computation of pixels from ray ends.
};

/// Time of a render with one schedule.
struct ScheduleTime {
    Schedule schedule;
    double seconds = 0;
    double idle_at_end = 0;  ///< Share of the time during which the thread that finished first is idle at the end.
};

/// Time of a render with one number of threads.
struct ThreadsTime {
    unsigned threads;
    double seconds = 0;
    double speedup = 1;  ///< Speedup over one thread, median over the rounds.
    /// Speedup of independent multiply-adds without memory access. It is the greatest speedup that the machine allows
    /// under its current load.
    double machine_speedup = 1;
};

/// Profile of a render. Times are those of the fastest run.
struct Profile {
    RunReport report;             ///< Report of the fastest recorded run.
    Recording recording;          ///< Tiles of that run, each with its shortest time over all recorded runs.
    StageTimes stages;            ///< Stage times of that run.
    double plain_seconds = 0;     ///< Time of the fastest run without recording.
    double recorded_seconds = 0;  ///< Time of the fastest run with recording.
    double overhead = 0;          ///< Relative cost of recording, median over the rounds.
    /// Correlation of predicted and measured tile costs. Empty if the schedule predicts no costs.
    std::optional<double> correlation;
    std::vector<ScheduleTime> schedules;  ///< All schedules, on all threads.
    std::vector<ThreadsTime> scaling;     ///< The plan's schedule on 1 to N threads.
    Operations operations{};              ///< Operations of a gradient and of a step. Zero if rays are straight.
    double all_operations = 0;            ///< Floating-point operations of the render.
    double peak_of_one = 0;               ///< Peak rate of one thread, operations per second.
    double peak_of_all = 0;               ///< Peak rate of all threads of the plan, operations per second.
    unsigned repeats = 0;                 ///< Number of completed rounds.
    bool interrupted = false;
};

/// Renders `film` repeatedly with all schedules and numbers of threads, and returns the profile. `repeats` is the
/// number of rounds. If it is 0, the rounds take about 20 seconds in all, with at least 3 and at most 50 rounds.
Profile profile(const Plan& plan, Film& film, unsigned repeats, const Progress& progress = {},
                const std::atomic<bool>* stop = nullptr);

/// Returns Pearson's correlation coefficient, or nothing if one of the lists is constant.
std::optional<double> correlation(const std::vector<double>& a, const std::vector<double>& b);

}  // namespace kagero

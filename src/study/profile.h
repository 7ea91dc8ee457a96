/// Profile of a render: the times of its stages, and its times with each schedule and number of threads. They are
/// measured in repeated renders of the same picture.
#pragma once

#include "render/render.h"

#include <optional>

namespace kagero {

/// Times of the stages in seconds, summed over threads.
struct StageTimes {
    double predict = 0;    ///< Prediction of tile costs: its duration times the number of threads.
    double list = 0;       ///< Generation of ray starts, if the kernel does not generate them.
    double integrate = 0;  ///< Tracing loop without queries and refinement.
    double query = 0;      ///< Embree queries, including the computation of the chords.
    double refine = 0;     ///< Refinement of events.
    double shade = 0;      ///< Computation of pixels from ray ends.
};

/// Time of a render with one schedule.
struct ScheduleTime {
    Schedule schedule;
    double seconds = 0;
    /// Time from the moment when the first thread finishes to the end of the render, divided by the render time.
    double idle_at_end = 0;
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

/// Profile of a render. Several configurations of the render, such as another schedule or number of threads, run once
/// per round. Times are those of the fastest run of a configuration.
struct Profile {
    RunReport report;             ///< Report of the fastest run with recording.
    Recording recording;          ///< Tiles of that run, each with its shortest time over all runs with recording.
    StageTimes stages;            ///< Stage times of that run.
    double plain_seconds = 0;     ///< Time of the fastest run without recording.
    double recorded_seconds = 0;  ///< Time of the fastest run with recording.
    double overhead = 0;          ///< Relative cost of recording, median over the rounds.
    /// Correlation of predicted and measured tile costs. Empty if the schedule predicts no costs.
    std::optional<double> correlation;
    std::vector<ScheduleTime> schedules;  ///< All schedules, on all threads.
    std::vector<ThreadsTime> scaling;     ///< The plan's schedule on 1 to N threads.
    Operations operations{};              ///< Operations of a gradient and of a step. Zero if rays are straight.
    double total_operations = 0;          ///< Floating-point operations of the render.
    double one_thread_peak = 0;           ///< Peak rate of one thread, operations per second.
    double all_threads_peak = 0;          ///< Peak rate of all threads of the plan, operations per second.
    unsigned rounds = 0;                  ///< Number of completed rounds.
    bool interrupted = false;             ///< True if the last round was not completed.
};

/// Renders `film` repeatedly, with all schedules on all threads and with the plan's schedule on fewer threads. Returns
/// the profile. If `rounds` is 0, the number of rounds is chosen, from 3 to 50, so that they take about 20 seconds in
/// all.
Profile profile(const Plan& plan, Film& film, unsigned rounds, const Progress& progress = {},
                const std::atomic<bool>* stop = nullptr);

/// Returns Pearson's correlation coefficient, or nothing if one of the lists is constant.
std::optional<double> correlation(const std::vector<double>& a, const std::vector<double>& b);

}  // namespace kagero

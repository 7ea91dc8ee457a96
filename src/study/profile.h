/// Where the time of a render goes, measured by rendering it again and again in different ways.
#pragma once

#include "render/render.h"

#include <optional>

namespace kagero {

/// Seconds, summed over threads.
struct StageTimes {
    double predict = 0;    ///< the sparse first pass: its length times the threads
    double list = 0;       ///< making rays, where the kernel does not
    double integrate = 0;  ///< the tracing loop without what follows
    double query = 0;      ///< asking Embree, and cutting steps into chords for it
    double refine = 0;     ///< delivering rays onto what ends them
    double shade = 0;
};

struct ScheduleTime {
    Schedule schedule;
    double seconds = 0;
    double idle_at_end = 0;  ///< of the thread that was out of work first, as a share
};

struct ThreadsTime {
    unsigned threads;
    double seconds = 0;
    double speedup = 1;  ///< over one thread: the median over rounds
    double machine =
        1;  ///< the same of multiply-adds alone: what these threads are worth while others use the machine too
};

struct Profile {
    RunReport report;     ///< of the quickest of the recorded runs
    Recording recording;  ///< … and its tiles
    StageTimes stages;
    double plain_seconds = 0, recorded_seconds = 0;  ///< the quickest run without recording, and with it
    double overhead = 0;                             ///< of recording, as a share: the median over rounds
    std::optional<double> correlation;               ///< of predicted and measured costs, where they were predicted
    std::vector<ScheduleTime> schedules;             ///< all of them, on all threads
    std::vector<ThreadsTime> scaling;                ///< the plan's schedule, on 1 … N threads
    Operations operations{};                         ///< of one ray; nothing where rays are straight
    double all_operations = 0;
    double peak_of_one = 0,
           peak_of_all = 0;  ///< multiply-adds alone, operations per second: one thread, all of the plan's
    unsigned repeats = 0;                     ///< runs of each kind; times are those of the quickest
    bool interrupted = false;
};

/// Renders `film` over and over, all ways in turn. `repeats`: how many rounds; 0: three, and up to fifty where the
/// picture takes so little time that one round says little.
Profile profile(const Plan& plan, Film& film, unsigned repeats, const Progress& progress = {},
                const std::atomic<bool>* stop = nullptr);

/// Pearson's; nothing where one of them does not vary.
std::optional<double> correlation(const std::vector<double>& a, const std::vector<double>& b);

}  // namespace kagero

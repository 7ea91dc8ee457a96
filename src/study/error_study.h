/// Error against run time for a scene's own rays: methods × steps × precisions, through the kernels and the loop that `render`
/// uses.
#pragma once

#include "render/deadline.h"
#include "accuracy/energy_drift.h"
#include "study/picture_error.h"
#include "accuracy/reference.h"
#include "study/strategy_times.h"

namespace kagero {

struct StudyOptions {
    std::uint32_t width = 64, height = 64;  ///< of the grid of sampled pixels
    bool quick = false;                     ///< a handful of methods, in double
    bool full = false;                      ///< every method one ray at a time too
    std::string strategy = "auto", precision = "auto";  ///< of the methods that are studied; "auto": every one
    /// Where it is not 0, errors of packets alone are measured, and nothing is timed, followed or drawn: sought are the longest steps whose 99th
    /// percentile of the error, in pixels, is within this, in float too.
    double pixel_bound = 0;
    Deadline deadline;                      ///< of the search for those steps: what was found by then is told. RunError if that is nothing
    unsigned threads = 1;                   ///< of the timed runs
    unsigned repeats = 5;                   ///< at least; of a quick study 1, for runs that take long
};

/// One method at one step.
struct StudyPoint {
    double step = 0;              ///< as the plan's job counts it; of adaptive methods: the tolerance
    double stated_step = 0;       ///< the same as a scene states it
    double solver_tolerance = 0;  ///< of implicit equations, relative; 0: to rounding
    Timing time;                  ///< ns per ray, with the scene's surfaces
    Timing time_without;          ///< no surfaces, no intersection: rays run on until they leave the scene, or as long as 99 % of those with
    double gradients = 0, steps = 0, queries = 0, iterations = 0;  ///< per ray; iterations of implicit solves
    double operations = 0;                                         ///< per ray, see render/operation_count.h
    double steps_without = 0;                                      ///< per ray, without surfaces
    double occupancy = 1;                                          ///< active lane-steps over issued ones
    RayErrors errors;
    EnergyDrift drift;
};

/// One method over its steps, the coarsest first.
struct StudyCurve {
    std::string method;
    Strategy strategy{};
    Precision precision{};
    const IntegratorInfo* info = nullptr;
    bool rescaled = false;
    bool loose = false;  ///< implicit equations solved to a hundredth of the error of the same step, not as the scene says
    bool own = false;    ///< the scene's own method
    std::optional<double> order;  ///< slope of position error (p90) over step, above the floor; none for adaptive methods
    std::optional<double> floor;  ///< least position error (p90) reached
    std::string stopped;          ///< why there are no finer steps
    std::vector<StudyPoint> points;
};

/// The quickest point whose 99th percentile of an error stays below a bound, and of whose rays at most 1 % end otherwise.
struct Cheapest {
    double error = 0;
    const char* measure = "";  ///< "pixels" or "direction"
    std::size_t curve = 0, point = 0;
    bool found = false;
};

struct ErrorStudy {
    StudyOptions options;
    SampleRays sample;
    ReferenceStory reference;
    std::uint64_t ill_conditioned = 0;
    Strategy strategy = Strategy::packet;          ///< of those that were studied, what tables and charts show,
    Precision precision = Precision::float64;      ///< … with few exceptions
    bool shows(const StudyCurve& curve) const { return curve.strategy == strategy && curve.precision == precision; }
    std::vector<StudyCurve> curves;
    std::vector<Cheapest> cheapest;
    std::vector<std::string> refused;  ///< methods that this space cannot serve
    std::vector<StrategyTime> strategies;  ///< of the scene's own method at its own step
    std::vector<EnergyTrace> energy;   ///< along one ray, as near to equal work as was measured
    std::vector<PictureError> pictures;
    ErrorMap map;
    double seconds = 0;
    bool interrupted = false;
};

/// Whether two methods agree on how at least 99 % of the rays end.
bool is_known(const ReferenceStory& reference);
/// In words, where it is not so.
std::string what_is_unknown(const ReferenceStory& reference);
/// Whether that is so, 99 % of them are within a bound, and at most 1 % end otherwise than they should.
bool is_within(const StudyPoint& point, double error, Spread RayErrors::*spread, const ReferenceStory& reference);

/// The plan is as before when this returns.
ErrorStudy study_error(Plan& plan, const StudyOptions& options, const Progress& progress = {},
                       const std::atomic<bool>* stop = nullptr);

}  // namespace kagero

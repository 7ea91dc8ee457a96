/// The error of methods over their steps, for a sample of a scene's own rays, through the kernels and the loop that
/// `render` uses.
#pragma once

#include "accuracy/energy_drift.h"
#include "accuracy/reference.h"
#include "accuracy/step_ladder.h"
#include "accuracy/timing.h"
#include "render/deadline.h"
#include "render/run_report.h"

namespace kagero {

struct CurveOptions {
    std::uint32_t width = 64, height = 64;  ///< of the grid of sampled pixels
    bool quick = false;                     ///< a handful of methods, in double
    bool full = false;                      ///< every method one ray at a time too
    std::optional<Strategy> strategy;       ///< of the methods that are measured; empty: every one
    std::optional<Precision> precision;     ///< likewise
    /// Where it is not 0, packets alone are measured, float included, and the longest steps are sought whose 99th
    /// percentile of the error, in pixels, is within this bound.
    double pixel_bound = 0;
    Deadline deadline;  ///< of the measurements: what was found by then is kept. RunError if that is nothing
};

/// One method at one step.
struct StudyPoint {
    double step = 0;              ///< as the kernels count it; of adaptive methods: the tolerance
    double stated_step = 0;       ///< the same as a scene states it
    double solver_tolerance = 0;  ///< of implicit equations, relative; 0: to rounding
    Timing time;                  ///< ns per ray, with the scene's surfaces
    Timing time_without;  ///< no surfaces, no intersection: rays run on until they leave the scene, or as long as 99 %
                          ///< of those with
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
    bool loose =
        false;  ///< implicit equations solved to a hundredth of the error of the same step, not as the scene says
    bool own = false;    ///< the scene's own method
    std::optional<double>
        order;  ///< slope of position error (p90) over step, above the floor; none for adaptive methods
    std::optional<double> floor;  ///< least position error (p90) reached
    std::string stopped;          ///< why there are no finer steps
    std::vector<StudyPoint> points;
};

struct ErrorCurves {
    SampleRays sample;
    ReferenceStory reference;
    std::uint64_t ill_conditioned = 0;
    std::vector<StudyCurve> curves;
    std::vector<std::string> refused;  ///< methods that this space cannot serve
    bool interrupted = false;
};

/// Whether two methods agree on how at least 99 % of the rays end.
bool is_known(const ReferenceStory& reference);
/// In words, where it is not so.
std::string what_is_unknown(const ReferenceStory& reference);
/// Whether that is so, 99 % of them are within a bound, and at most 1 % end otherwise than they should.
bool is_within(const StudyPoint& point, double error, Spread RayErrors::*spread, const ReferenceStory& reference);

/// Measures curves: `prepare` chooses the rays and traces their reference, `climb_all` measures method after method.
class CurveBuilder {
public:
    /// Called for each point that was measured, with what its run reported and the ends of its rays. False where there
    /// was no time to complete the point: it is dropped then.
    using Measured = std::function<bool(const Variant&, std::size_t curve, StudyPoint& point, const RunReport&,
                                        const std::vector<RayEnd>&)>;

    CurveBuilder(const Plan& plan, const CurveOptions& options, const std::atomic<bool>* stop)
        : plan_(plan), options_(options), stop_(stop) {}

    void prepare();
    /// `progress` is called with the finished share.
    void climb_all(const std::function<void(double)>& progress, const Measured& measured = {});

    /// With a limit of steps that suits the rays of the sample.
    const Plan& plan() const { return plan_; }
    const ErrorCurves& curves() const { return curves_; }
    const ReferenceRays& reference_rays() const { return reference_; }
    bool stopped() const { return (stop_ && stop_->load(std::memory_order_relaxed)) || options_.deadline.passed(); }
    Watch watch() const { return {.stop = stop_, .time_limit = options_.deadline.left()}; }
    ErrorCurves take();

private:
    void bound_steps();
    void keep_decided();
    void climb(const Ladder& ladder, const Measured& measured);
    void close_in(StudyCurve& curve, Variant variant);
    bool set_loose_tolerance(Variant& variant) const;
    std::optional<StudyPoint> measure(const Variant& variant, const Measured& measured) const;

    Plan plan_;
    const CurveOptions options_;
    const std::atomic<bool>* stop_;
    ErrorCurves curves_;
    ReferenceRays reference_;
    double least_work_ = std::numeric_limits<double>::infinity();
};

/// Both in one call.
ErrorCurves measure_curves(const Plan& plan, const CurveOptions& options, const Progress& progress = {},
                           const std::atomic<bool>* stop = nullptr);

}  // namespace kagero

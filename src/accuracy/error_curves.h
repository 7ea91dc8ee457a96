/// Error of integration methods as a function of their step, measured on a sample of a scene's camera rays with the
/// kernels that `render` uses.
#pragma once

#include "accuracy/energy_drift.h"
#include "accuracy/reference.h"
#include "accuracy/step_ladder.h"
#include "accuracy/timing.h"
#include "render/deadline.h"
#include "render/run_report.h"

namespace kagero {

/// Options of a measurement of error curves.
struct CurveOptions {
    std::uint32_t width = 64, height = 64;  ///< Size of the grid of sampled pixels.
    /// True: only the scene's method and the representative methods are measured, the latter in double only.
    bool quick = false;
    /// True: every method is measured with the strategy `scalar` too. False: only the scene's method is measured with
    /// `scalar`, unless `strategy` is set.
    bool full = false;
    std::optional<Strategy> strategy;    ///< Strategy to measure. Empty: `packet` and `scalar`.
    std::optional<Precision> precision;  ///< Precision to measure. Empty: both precisions.
    /// Bound on the 99th percentile of the pixel error; 0 means no bound. With a bound, only the strategy `packet` is
    /// measured, in double and in float, and the longest step of each method that meets the bound is searched.
    double pixel_bound = 0;
    /// End of the time for measurements. Points that were measured before the deadline are kept. RunError is thrown if
    /// the reference is not complete at the deadline.
    Deadline deadline;
};

/// Measurements of one method at one step.
struct StudyPoint {
    double step = 0;              ///< Step in the kernel's unit, or the tolerance of an adaptive method.
    double stated_step = 0;       ///< The same step in the unit of a scene file.
    double solver_tolerance = 0;  ///< Relative solver tolerance of implicit methods; 0: iterate to rounding.
    Timing time;                  ///< Nanoseconds per ray, with the scene's surfaces.
    /// Nanoseconds per ray without surfaces and intersection tests. A ray that neither escapes nor is captured ends
    /// after one step more than 99 % of the rays need with surfaces.
    Timing time_without_surfaces;
    double gradients = 0;               ///< Gradient evaluations per ray.
    double steps = 0;                   ///< Steps per ray.
    double queries = 0;                 ///< Embree queries per ray.
    double iterations = 0;              ///< Iterations of implicit solves per ray.
    double operations = 0;              ///< Floating-point operations per ray, see render/operation_count.h.
    double steps_without_surfaces = 0;  ///< Steps per ray without surfaces.
    double occupancy = 1;               ///< Active lane-steps divided by issued lane-steps.
    RayErrors errors;                   ///< Errors of the ray ends against the reference.
    EnergyDrift drift;                  ///< Energy errors along a few of the rays.
};

/// Measurements of one method over its steps, the coarsest step first.
struct StudyCurve {
    std::string method;
    Strategy strategy{};
    Precision precision{};
    const IntegratorInfo* info = nullptr;  ///< Description of the method.
    bool rescaled = false;                 ///< True if H is integrated with time rescaling.
    /// True if the solver tolerance is a hundredth of the median direction error that the method has at the same step.
    /// False if the solver tolerance is that of the scene.
    bool has_loose_solver = false;
    bool is_scene_method = false;  ///< True if this is the method of the scene.
    /// Measured order: slope of log position error (90th percentile) over log step, above the error floor. Empty for
    /// adaptive methods.
    std::optional<double> order;
    std::optional<double> floor;  ///< Smallest 90th percentile of the position error over all steps, scene units.
    std::string stop_reason;      ///< Reason why no finer step was measured; empty if all steps were measured.
    std::vector<StudyPoint> points;
};

/// Error curves of all measured methods, with their reference.
struct ErrorCurves {
    SampleRays sample;
    ReferenceSummary reference;
    std::uint64_t ill_conditioned_rays = 0;  ///< Number of ill-conditioned rays in the sample, see ray_errors.h.
    std::vector<StudyCurve> curves;
    std::vector<std::string> refused;  ///< Methods that do not support this space.
    bool interrupted = false;          ///< True if some points were not measured, because of the deadline or a stop.
};

/// Returns true if two methods agree on the status and the object of at least 99 % of the ray ends.
bool is_confirmed(const ReferenceSummary& reference);
/// Returns a message for a reference that is not confirmed: the number of rays on which the methods disagree.
std::string describe_disagreement(const ReferenceSummary& reference);
/// Returns true if the point meets a bound on a quantity of RayErrors. The 99th percentiles of the point's error and of
/// the reference's uncertainty must be at most `bound`. The reference must be confirmed, and at most 1 % of the rays
/// may be flips. A point whose rays are all captured meets every bound.
bool is_within(const StudyPoint& point, double bound, Percentiles RayErrors::*quantity,
               const ReferenceSummary& reference);

/// A share of the methods: each `count`-th one of those that are measured, from method number `first` on.
struct MethodShare {
    std::uint32_t first = 0, count = 1;
};

/// Measures error curves in three calls. `prepare` chooses the rays and traces their reference, `measure_ladders`
/// measures all methods, and `finish` returns the result.
class CurveBuilder {
public:
    /// Callback for each measured point, with the index of its curve, the report of its run and its ray ends. The
    /// callback may set further members of the point. The point is dropped if the callback returns false.
    using PointCallback = std::function<bool(const Variant&, std::size_t curve, StudyPoint& point, const RunReport&,
                                             const std::vector<RayEnd>&)>;

    /// Callback before each point. The point is not measured if the callback returns it.
    using PointRestorer = std::function<std::optional<StudyPoint>(const Variant&)>;

    CurveBuilder(const Plan& plan, const CurveOptions& options, const std::atomic<bool>* stop)
        : plan_(plan), options_(options), stop_(stop) {}

    /// Chooses the sample rays and traces their reference. Throws RunError if no ray has a confirmed end.
    void prepare();
    /// Measures every selected method of `share` over its step ladder, and replaces the curves of an earlier call.
    /// Calls `progress` with the finished share, from 0 to 1. A share of the methods gets at least the points that it
    /// has in a measurement of all methods.
    void measure_ladders(const std::function<void(double)>& progress, const PointCallback& on_point = {},
                         const PointRestorer& restore = {}, const MethodShare& share = {});

    /// Returns the plan of the measurements. `prepare` reduces its `max_steps` to 30 times the median number of steps
    /// of the sample rays, but not below 1000.
    const Plan& plan() const { return plan_; }
    const ErrorCurves& curves() const { return curves_; }
    const ReferenceRays& reference_rays() const { return reference_; }
    /// Returns true if the measurement must end: because of `stop` or the deadline.
    bool stopped() const { return (stop_ && stop_->load(std::memory_order_relaxed)) || options_.deadline.passed(); }
    /// Returns the conditions that end a run of the measurement.
    RunControl control() const { return {.stop = stop_, .time_limit = options_.deadline.remaining_seconds()}; }
    /// Moves the curves out of the builder. Call it last.
    ErrorCurves finish();

private:
    void reduce_max_steps();
    void keep_confirmed_rays();
    void measure_ladder(const Ladder& ladder, const PointCallback& on_point, const PointRestorer& restore);
    void bisect_longest_step(StudyCurve& curve, Variant variant);
    bool set_loose_tolerance(Variant& variant) const;
    std::optional<StudyPoint> measure(const Variant& variant, const PointCallback& on_point) const;

    Plan plan_;
    const CurveOptions options_;
    const std::atomic<bool>* stop_;
    ErrorCurves curves_;
    ReferenceRays reference_;
    double least_work_ = std::numeric_limits<double>::infinity();  ///< Work per ray of the cheapest measured point.
};

/// Chooses the sample, measures all ladders and returns the curves. With a pixel bound, no curve is measured if the
/// reference is not confirmed.
ErrorCurves measure_curves(const Plan& plan, const CurveOptions& options, const Progress& progress = {},
                           const std::atomic<bool>* stop = nullptr);

}  // namespace kagero

#include "accuracy/error_curves.h"

#include "error.h"
#include "render/operation_count.h"
#include "render/trace.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace kagero {
namespace {

/// Greatest share of flips, and greatest share of rays without a confirmed reference, with which a bound can count as
/// met.
constexpr double max_disagreeing_share = 0.01;
/// Greatest work per ray at which a method is measured, divided by the work of the cheapest point. Work is the number
/// of gradients or of steps, whichever is greater.
constexpr double max_relative_work = 200, max_relative_work_quick = 60;
/// Greatest predicted work of a point, summed over the rays, with CurveOptions::quick. Work is limited instead of time,
/// so that repeated studies measure the same points.
constexpr double max_work_quick = 2e7;
/// The same limit for a ladder with at least `points_for_order` measured steps, but fewer than Ladder::min_steps.
constexpr double max_work_quick_few_points = 4e8;
/// Number of points that suffice to determine the order of a method.
constexpr std::size_t points_for_order = 3;
/// An error counts as limited by rounding if it is below `rounding_limit` times the scene size, and exceeds
/// `stagnation_ratio` times the error of the previous, coarser step.
constexpr double rounding_limit = 1e-5, stagnation_ratio = 0.7;
/// Ratio to the work of the previous point above which work counts as rising.
constexpr double rising_work_ratio = 1.2;
/// Predicted ratio of the next step's work to this step's work, for the next smaller tolerance and for half the step.
constexpr double work_of_next_tolerance = 1.5, work_of_half_step = 2;
/// Limit of steps per ray: a multiple of the median over the rays that do not reach max_steps, but at least
/// `least_step_limit`.
constexpr double step_limit_over_median = 30;
constexpr std::uint32_t least_step_limit = 1000;

}  // namespace

void CurveBuilder::prepare() {
    curves_.sample = sample_rays(plan_, options_.width, options_.height);
    reduce_max_steps();
    reference_ = trace_reference(plan_, curves_.sample, curves_.reference, options_.deadline, stop_);
    keep_confirmed_rays();
    for (std::size_t i = 0; i < reference_.ends.size(); ++i)
        curves_.ill_conditioned_rays += reference_.confirmed[i] && reference_.conditioning[i] > conditioning_limit;
}

/// Reduces max_steps of the plan. Otherwise, rays on closed orbits would take the greatest number of steps that the
/// scene permits, at every step size.
void CurveBuilder::reduce_max_steps() {
    std::vector<RayEnd> ends;
    trace(plan_, curves_.sample.starts, ends, control());
    std::vector<double> steps;
    for (const RayEnd& end : ends)
        if (end.status != Status::step_limit) steps.push_back(end.steps);
    const double median = percentiles_of(std::move(steps)).p50;
    const auto step_limit = static_cast<std::uint32_t>(std::min(1e9, step_limit_over_median * median));
    plan_.run.max_steps = std::min(plan_.run.max_steps, std::max(least_step_limit, step_limit));
}

/// Removes the rays without a confirmed reference: no error is defined for them, and tracing them would cost time.
void CurveBuilder::keep_confirmed_rays() {
    std::size_t kept = 0;
    SampleRays& sample = curves_.sample;
    for (std::size_t i = 0; i < reference_.ends.size(); ++i) {
        if (!reference_.confirmed[i]) continue;
        sample.starts[kept] = sample.starts[i];
        sample.pixels[kept] = sample.pixels[i];
        reference_.ends[kept] = reference_.ends[i];
        reference_.conditioning[kept] = reference_.conditioning[i];
        ++kept;
    }
    if (kept == 0)
        throw RunError(
            "no error can be measured in this scene: no ray has an end that two methods agree on; raise "
            "integrator.max_steps, or choose a view from which more rays end");
    sample.starts.resize(kept);
    sample.pixels.resize(kept);
    reference_.ends.resize(kept);
    reference_.conditioning.resize(kept);
    reference_.confirmed.assign(kept, true);
}

void CurveBuilder::measure_ladders(const std::function<void(double)>& progress, const PointCallback& on_point,
                                   const PointRestorer& restore, const MethodShare& share) {
    curves_.curves.clear();
    curves_.refused.clear();
    least_work_ = std::numeric_limits<double>::infinity();
    std::vector<std::uint32_t> methods;
    const LadderChoice choice{options_.quick, options_.full, options_.strategy, options_.precision,
                              options_.pixel_bound > 0};
    const auto ladders = choose_ladders(plan_, choice, curves_.refused);
    for (std::size_t i = 0; i < ladders.size() && !stopped(); ++i) {
        if (options_.pixel_bound && ladders[i].variant.kernel->strategy != Strategy::packet) continue;
        // All ladders of a method are in one share, because some need the errors of another one.
        const std::uint32_t method = ladders[i].variant.method.integrator;
        const auto found = std::find(methods.begin(), methods.end(), method);
        const auto number = static_cast<std::uint32_t>(found - methods.begin());
        if (found == methods.end()) methods.push_back(method);
        if (number % share.count != share.first) continue;
        measure_ladder(ladders[i], on_point, restore);
        progress(double(i + 1) / double(ladders.size()));
    }
}

/// Measures one method from the coarsest step to the finest. Stops early if rounding limits the error, if the work of
/// the next step would exceed a limit, or if the deadline has passed.
void CurveBuilder::measure_ladder(const Ladder& ladder, const PointCallback& on_point, const PointRestorer& restore) {
    StudyCurve& curve = curves_.curves.emplace_back();
    curve.info = &info_of(plan_, ladder.variant);
    curve.method = curve.info->name;
    curve.strategy = ladder.variant.kernel->strategy;
    curve.precision = ladder.variant.kernel->precision;
    curve.rescaled = ladder.variant.method.rescaled;
    curve.is_scene_method = ladder.is_scene_method;
    curve.has_loose_solver = ladder.has_loose_solver;
    const double size = scene_size(*plan_.scene);
    std::vector<double> steps, errors;
    Variant variant = ladder.variant;
    double work_before = 0;
    for (std::size_t n = 0; n < ladder.steps.size() && !stopped(); ++n) {
        variant.step = ladder.steps[n];
        if (ladder.has_loose_solver && !set_loose_tolerance(variant)) break;
        const auto restored = restore ? restore(variant) : std::optional<StudyPoint>();
        const auto measured = restored ? restored : measure(variant, on_point);
        if (!measured) break;
        const StudyPoint& point = *measured;
        curve.points.push_back(point);
        steps.push_back(variant.step);
        errors.push_back(point.errors.position.p90);
        const double work = std::max(point.gradients, point.steps);
        if (point.errors.compared > 0) least_work_ = std::min(least_work_, work);
        const bool has_min_points = n + 1 >= ladder.min_steps;
        const double error = errors.back(), previous_error = n > 0 ? errors[n - 1] : error;
        if (has_min_points && error < rounding_limit * size && error > stagnation_ratio * previous_error) {
            curve.stop_reason = "rounding limits the error: a finer step does not reduce it";
            break;
        }
        const double max_ratio = options_.quick ? max_relative_work_quick : max_relative_work;
        // A long step of an implicit method may cost more than a shorter step, which needs fewer iterations.
        const bool work_rises = n > 0 && work > rising_work_ratio * work_before;
        work_before = work;
        const double next_work = (curve.info->adaptive ? work_of_next_tolerance : work_of_half_step) * work;
        if (has_min_points && work_rises && next_work > max_ratio * least_work_) {
            curve.stop_reason = "a finer step would need more than " + std::to_string(std::lround(max_ratio)) +
                                " times the work of the cheapest point";
            break;
        }
        const double max_work = has_min_points ? max_work_quick : max_work_quick_few_points;
        if (work_rises && options_.quick && n + 1 >= points_for_order &&
            next_work * double(curves_.sample.starts.size()) > max_work) {
            curve.stop_reason = "a finer step would exceed the work limit of a quick study (--quick)";
            break;
        }
    }
    const LadderFit fit = fit_ladder(steps, errors, curve.info->order, size);
    curve.floor = fit.floor;
    if (!curve.info->adaptive) curve.order = fit.order;
    if (curve.points.empty()) curves_.curves.pop_back();
    else if (options_.pixel_bound) bisect_longest_step(curve, variant);
}

/// Bisects between the longest measured step that meets the pixel bound and the next longer step, which does not. If no
/// longer step was measured, first doubles the step, up to three times, until a step does not meet the bound. Adds the
/// measured points to the curve.
void CurveBuilder::bisect_longest_step(StudyCurve& curve, Variant variant) {
    constexpr int doublings = 3, bisections = 4;
    const auto measure_step = [&](double step) {
        variant.step = step;
        return measure(variant, {});
    };
    const auto meets_bound = [&](const StudyPoint& point) {
        return is_within(point, options_.pixel_bound, &RayErrors::pixels, curves_.reference);
    };
    auto longest = std::find_if(curve.points.begin(), curve.points.end(), meets_bound);
    if (longest == curve.points.end()) return;
    if (curve.has_loose_solver) variant.solver_tolerance = longest->solver_tolerance;
    const auto insert = [&](double step) {
        const auto point = measure_step(step);
        if (!point) return false;
        longest = curve.points.insert(longest, *point);
        if (!meets_bound(*point)) ++longest;
        return true;
    };
    for (int i = 0; i < doublings && longest == curve.points.begin(); ++i)
        if (!insert(2 * longest->step)) return;
    for (int i = 0; i < bisections && longest != curve.points.begin(); ++i)
        if (!insert(std::sqrt(std::prev(longest)->step * longest->step))) return;
}

/// Sets the solver tolerance of the variant to a hundredth of the median direction error that was measured for the same
/// method and step with equations solved to rounding. Returns false if no such error was measured, if it is a rounding
/// error, or if the method did not iterate.
bool CurveBuilder::set_loose_tolerance(Variant& variant) const {
    for (const StudyCurve& curve : curves_.curves) {
        if (curve.info != &info_of(plan_, variant) || curve.has_loose_solver || curve.precision != Precision::float64)
            continue;
        for (const StudyPoint& point : curve.points) {
            if (point.step != variant.step || !(point.errors.direction.p50 > 1e-13) || point.iterations == 0) continue;
            variant.solver_tolerance = 0.01 * std::min(1.0, point.errors.direction.p50);
            return true;
        }
    }
    return false;
}

/// Traces the sample with the variant and returns the measurements, or nullopt if the run was interrupted or the
/// callback dropped the point.
std::optional<StudyPoint> CurveBuilder::measure(const Variant& variant, const PointCallback& on_point) const {
    if (stopped()) return {};
    const Plan plan = plan_with_variant(plan_, variant);
    StudyPoint point;
    point.step = variant.step;
    point.stated_step = stated_step(plan_, variant);
    point.solver_tolerance = plan.run.solver_tolerance;
    const double rays = double(curves_.sample.starts.size());
    std::vector<RayEnd> ends;
    const RunReport report = trace(plan, curves_.sample.starts, ends, control());
    if (report.interrupted) return {};
    point.errors = compare_rays(plan_, reference_, ends);
    const Counters& work = report.counters;
    point.gradients = double(work.gradients) / rays;
    point.steps = double(work.steps) / rays;
    point.operations = operations_of(plan, work) / rays;
    point.queries = double(work.queries) / rays;
    point.iterations = double(work.active_iterations) / rays;
    if (work.issued_lane_steps > 0) point.occupancy = double(work.active_lane_steps) / double(work.issued_lane_steps);
    if (on_point && !on_point(variant, curves_.curves.size() - 1, point, report, ends)) return {};
    return point;
}

ErrorCurves CurveBuilder::finish() {
    curves_.interrupted = stopped();
    return std::move(curves_);
}

bool is_confirmed(const ReferenceSummary& reference) {
    return double(reference.unconfirmed) <= max_disagreeing_share * double(reference.confirmed + reference.unconfirmed);
}

std::string describe_disagreement(const ReferenceSummary& reference) {
    return "no two methods agree on the ends of " + std::to_string(reference.unconfirmed) + " of " +
           std::to_string(reference.confirmed + reference.unconfirmed) + " rays; at most 1 % may differ";
}

bool is_within(const StudyPoint& point, double bound, Percentiles RayErrors::*quantity,
               const ReferenceSummary& reference) {
    const RayErrors& e = point.errors;
    if (reference.confirmed == 0 || !is_confirmed(reference)) return false;
    if (double(e.flips) > max_disagreeing_share * double(reference.confirmed)) return false;
    if (e.compared + e.compared_ill_conditioned == 0) return true;  // all rays are captured and have no position error
    // An error below the uncertainty of the reference cannot be measured.
    const double uncertainty = quantity == &RayErrors::pixels     ? reference.pixels.p99
                               : quantity == &RayErrors::position ? reference.uncertainty.p99
                                                                  : reference.direction.p99;
    return (e.*quantity).p99 <= bound && uncertainty <= bound;
}

ErrorCurves measure_curves(const Plan& plan, const CurveOptions& options, const Progress& progress,
                           const std::atomic<bool>* stop) {
    const auto begin = std::chrono::steady_clock::now();
    CurveBuilder builder(plan, options, stop);
    builder.prepare();
    const auto report = [&](double done) {
        if (progress) progress(done, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    };
    if (!options.pixel_bound || is_confirmed(builder.curves().reference)) builder.measure_ladders(report);
    return builder.finish();
}

}  // namespace kagero

#include "accuracy/error_curves.h"

#include "error.h"
#include "render/operation_count.h"
#include "render/trace.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace kagero {
namespace {

/// The greatest share of rays with a wrong or unknown class of end, if the others are to count as within a bound.
constexpr double most_astray = 0.01;
/// Points that do more work per ray than this many times the cheapest are not worth their wait.
constexpr double absurd_work = 200, absurd_work_quick = 60;
/// Gradients and steps of all rays beyond which a quick study takes no finer step: counted, as a clock would not choose
/// the same points twice.
constexpr double most_work_quick = 2e7;
/// The same before a method has shown as many steps as others, but enough for its order.
constexpr double hopeless_work_quick = 4e8;
constexpr std::size_t steps_for_order = 3;
/// A finer step gains nothing where the error, below this share of the scene, falls to no less than so much of what it
/// was.
constexpr double resolved = 1e-5, hardly_less = 0.7;
/// Work rises where a point does so many times that of the one before; the next will, of a tenth of the tolerance or
/// half the step.
constexpr double rises_by = 1.2, next_tolerance = 1.5, next_halving = 2;
/// A ray that takes so many times as many steps as the middle one of those that end does not end; but never fewer steps
/// than this.
constexpr double far_beyond = 30;
constexpr std::uint32_t least_steps = 1000;

}  // namespace

void CurveBuilder::prepare() {
    curves_.sample = sample_rays(plan_, options_.width, options_.height);
    bound_steps();
    reference_ = trace_reference(plan_, curves_.sample, curves_.reference, options_.deadline, stop_);
    keep_decided();
    for (std::size_t i = 0; i < reference_.ends.size(); ++i)
        curves_.ill_conditioned += reference_.decided[i] && reference_.conditioning[i] > ill_conditioned;
}

/// Where light can circle for ever, rays would run to the scene's limit of steps at every point of the study. They end
/// far beyond what the middle one of those needs that end by themselves.
void CurveBuilder::bound_steps() {
    std::vector<RayEnd> ends;
    trace(plan_, curves_.sample.starts, ends, watch());
    std::vector<double> steps;
    for (const RayEnd& end : ends)
        if (end.status != Status::step_limit) steps.push_back(end.steps);
    const auto enough = static_cast<std::uint32_t>(std::min(1e9, far_beyond * spread_of(std::move(steps)).p50));
    plan_.run.max_steps = std::min(plan_.run.max_steps, std::max(least_steps, enough));
}

/// Rays without a reference have no error; they would only take time.
void CurveBuilder::keep_decided() {
    std::size_t kept = 0;
    SampleRays& sample = curves_.sample;
    for (std::size_t i = 0; i < reference_.ends.size(); ++i) {
        if (!reference_.decided[i]) continue;
        sample.starts[kept] = sample.starts[i], sample.pixels[kept] = sample.pixels[i];
        reference_.ends[kept] = reference_.ends[i], reference_.conditioning[kept] = reference_.conditioning[i];
        ++kept;
    }
    if (kept == 0)
        throw RunError("no ray of this scene ends in a way that two methods agree on: there is no error to measure");
    sample.starts.resize(kept), sample.pixels.resize(kept);
    reference_.ends.resize(kept), reference_.conditioning.resize(kept);
    reference_.decided.assign(kept, true);
}

void CurveBuilder::climb_all(const std::function<void(double)>& progress, const Measured& measured) {
    const LadderChoice choice{options_.quick, options_.full, options_.strategy, options_.precision,
                              options_.pixel_bound > 0};
    const auto ladders = choose_ladders(plan_, choice, curves_.refused);
    for (std::size_t i = 0; i < ladders.size() && !stopped(); ++i) {
        if (options_.pixel_bound && ladders[i].variant.kernel->strategy != Strategy::packet) continue;
        climb(ladders[i], measured);
        progress(double(i + 1) / double(ladders.size()));
    }
}

/// Finer and finer steps until rounding stops the method, or its cost is absurd.
void CurveBuilder::climb(const Ladder& ladder, const Measured& hook) {
    StudyCurve& curve = curves_.curves.emplace_back();
    curve.info = &info_of(plan_, ladder.variant), curve.method = curve.info->name;
    curve.strategy = ladder.variant.kernel->strategy, curve.precision = ladder.variant.kernel->precision;
    curve.rescaled = ladder.variant.method.rescaled, curve.own = ladder.own, curve.loose = ladder.loose;
    const double size = scene_size(*plan_.scene);
    std::vector<double> steps, errors;
    Variant variant = ladder.variant;
    double work_before = 0;
    for (std::size_t n = 0; n < ladder.steps.size() && !stopped(); ++n) {
        variant.step = ladder.steps[n];
        if (ladder.loose && !set_loose_tolerance(variant)) break;
        const auto measured = measure(variant, hook);
        if (!measured) break;
        const StudyPoint& point = *measured;
        curve.points.push_back(point);
        steps.push_back(variant.step), errors.push_back(point.errors.position.p90);
        const double work = std::max(point.gradients, point.steps);
        if (point.errors.compared > 0) least_work_ = std::min(least_work_, work);
        const bool enough = n + 1 >= ladder.least;
        const double error = errors.back(), before = n > 0 ? errors[n - 1] : error;
        if (enough && error < resolved * size && error > hardly_less * before) {
            curve.stopped = "rounding: a finer step gains nothing";
            break;
        }
        const double limit = options_.quick ? absurd_work_quick : absurd_work;
        // Long steps of implicit methods may cost more than shorter ones, whose equations are solved sooner.
        const bool rises = n > 0 && work > rises_by * work_before;
        work_before = work;
        const double next = (curve.info->adaptive ? next_tolerance : next_halving) * work;
        if (enough && rises && next > limit * least_work_) {
            curve.stopped = "a finer step would do more than " + std::to_string(std::lround(limit)) +
                            " times the work of the cheapest point";
            break;
        }
        const double most_work = enough ? most_work_quick : hopeless_work_quick;
        if (rises && options_.quick && n + 1 >= steps_for_order &&
            next * double(curves_.sample.starts.size()) > most_work) {
            curve.stopped = "a finer step is too much work for a quick study";
            break;
        }
    }
    const Slope slope = slope_of(steps, errors, curve.info->order, size);
    curve.floor = slope.floor;
    if (!curve.info->adaptive) curve.order = slope.order;
    if (curve.points.empty()) curves_.curves.pop_back();
    else if (options_.pixel_bound) close_in(curve, variant);
}

/// Bisects between the longest step that is within the bound and the next longer one, which is not.
void CurveBuilder::close_in(StudyCurve& curve, Variant variant) {
    constexpr int doublings = 3, bisections = 4;
    const auto measured = [&](double step) {
        variant.step = step;
        return measure(variant, {});
    };
    const auto within = [&](const StudyPoint& point) {
        return is_within(point, options_.pixel_bound, &RayErrors::pixels, curves_.reference);
    };
    auto longest = std::find_if(curve.points.begin(), curve.points.end(), within);
    if (longest == curve.points.end()) return;
    if (curve.loose) variant.solver_tolerance = longest->solver_tolerance;
    const auto insert = [&](double step) {
        const auto point = measured(step);
        if (!point) return false;
        longest = curve.points.insert(longest, *point);
        if (!within(*point)) ++longest;
        return true;
    };
    for (int i = 0; i < doublings && longest == curve.points.begin(); ++i)
        if (!insert(2 * longest->step)) return;
    for (int i = 0; i < bisections && longest != curve.points.begin(); ++i)
        if (!insert(std::sqrt(std::prev(longest)->step * longest->step))) return;
}

/// To a hundredth of the error that the same method makes at the same step when its equations are solved exactly. False
/// where that was not measured, rounding is all there is, or this space leaves no equations to solve.
bool CurveBuilder::set_loose_tolerance(Variant& variant) const {
    for (const StudyCurve& curve : curves_.curves) {
        if (curve.info != &info_of(plan_, variant) || curve.loose || curve.precision != Precision::float64) continue;
        for (const StudyPoint& point : curve.points) {
            if (point.step != variant.step || !(point.errors.direction.p50 > 1e-13) || point.iterations == 0) continue;
            variant.solver_tolerance = 0.01 * std::min(1.0, point.errors.direction.p50);
            return true;
        }
    }
    return false;
}

/// Nothing where there was no time.
std::optional<StudyPoint> CurveBuilder::measure(const Variant& variant, const Measured& measured) const {
    if (stopped()) return {};
    const Plan plan = plan_by(plan_, variant);
    StudyPoint point;
    point.step = variant.step, point.stated_step = stated_step(plan_, variant);
    point.solver_tolerance = plan.run.solver_tolerance;
    const double rays = double(curves_.sample.starts.size());
    std::vector<RayEnd> ends;
    const RunReport report = trace(plan, curves_.sample.starts, ends, watch());
    if (report.interrupted) return {};
    point.errors = compare_rays(plan_, reference_, ends);
    const Counters& work = report.counters;
    point.gradients = double(work.gradients) / rays, point.steps = double(work.steps) / rays;
    point.operations = operations_of(plan, work) / rays;
    point.queries = double(work.queries) / rays, point.iterations = double(work.active_iterations) / rays;
    if (work.issued_lane_steps > 0) point.occupancy = double(work.active_lane_steps) / double(work.issued_lane_steps);
    if (measured && !measured(variant, curves_.curves.size() - 1, point, report, ends)) return {};
    return point;
}

ErrorCurves CurveBuilder::take() {
    curves_.interrupted = stopped();
    return std::move(curves_);
}

bool is_known(const ReferenceStory& reference) {
    return double(reference.undecided) <= most_astray * double(reference.decided + reference.undecided);
}

std::string what_is_unknown(const ReferenceStory& reference) {
    return "no two methods agree on how " + std::to_string(reference.undecided) + " of " +
           std::to_string(reference.decided + reference.undecided) + " rays end";
}

bool is_within(const StudyPoint& point, double error, Spread RayErrors::*spread, const ReferenceStory& reference) {
    const RayErrors& e = point.errors;
    if (reference.decided == 0 || !is_known(reference) || double(e.flips) > most_astray * double(reference.decided))
        return false;
    if (e.compared + e.ill == 0) return true;  // rays that are all captured end nowhere in particular
    // Of what is closer to the reference than that is to the truth nobody knows how close it is to that.
    const double unknown = spread == &RayErrors::pixels     ? reference.pixels.p99
                           : spread == &RayErrors::position ? reference.uncertainty.p99
                                                            : reference.direction.p99;
    return (e.*spread).p99 <= error && unknown <= error;
}

ErrorCurves measure_curves(const Plan& plan, const CurveOptions& options, const Progress& progress,
                           const std::atomic<bool>* stop) {
    const auto begin = std::chrono::steady_clock::now();
    CurveBuilder builder(plan, options, stop);
    builder.prepare();
    const auto report = [&](double done) {
        if (progress) progress(done, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    };
    if (!options.pixel_bound || is_known(builder.curves().reference)) builder.climb_all(report);
    return builder.take();
}

}  // namespace kagero

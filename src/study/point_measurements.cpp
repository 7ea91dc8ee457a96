#include "study/point_measurements.h"

#include "render/trace.h"

#include <algorithm>

namespace kagero {
namespace {

/// Greatest number of rays on which the energy drift of a method is measured.
constexpr std::size_t max_drift_rays = 8;
/// A quick study measures errors on all rays and threads, but times only every fourth block of adjacent rays.
constexpr std::size_t rays_per_block = 64, timed_block_interval = 4;

/// Returns the limit of steps for runs without surfaces: one more than 99 % of the rays need with surfaces. `ends` are
/// the ray ends with surfaces. Without this limit, rays on closed orbits would run to the scene's limit.
std::uint32_t step_limit_of(const std::vector<RayEnd>& ends) {
    std::vector<double> steps;
    for (const RayEnd& end : ends) steps.push_back(end.steps);
    return static_cast<std::uint32_t>(percentiles_of(std::move(steps)).p99) + 1;
}

}  // namespace

Plan without_surfaces(Plan plan, std::uint32_t max_steps) {
    if (!plan.scene->geometry->kernel_view()) return plan;
    plan.run.surfaces = false;
    plan.run.max_steps = std::min(plan.run.max_steps, max_steps);
    return plan;
}

void PointMeasurements::prepare() {
    builder_.prepare();
    choose_drift_rays();
    choose_timed_rays();
}

Plan PointMeasurements::plan_for_timing(const Variant& variant) const {
    Plan timed = plan_with_variant(plan(), variant);
    timed.run.threads = options_.threads;
    return timed;
}

/// Chooses up to `max_drift_rays` rays with a conditioning below 100, from all parts of the picture. The energy error
/// of an ill-conditioned ray would depend more on the ray than on the method. The energy traces are recorded along the
/// ray with the greatest conditioning below 100.
void PointMeasurements::choose_drift_rays() {
    const ReferenceRays& rays = builder_.reference_rays();
    constexpr double max_conditioning = 100;
    std::vector<std::size_t> candidates;
    for (std::size_t i = 0; i < rays.ends.size(); ++i) {
        const Status status = rays.ends[i].status;
        if (!rays.confirmed[i] || (status != Status::hit && status != Status::escaped)) continue;
        if (!(rays.conditioning[i] < max_conditioning)) continue;
        if (candidates.empty() || rays.conditioning[i] > rays.conditioning[energy_ray_]) energy_ray_ = i;
        candidates.push_back(i);
    }
    const std::size_t count = std::min(max_drift_rays, candidates.size());
    for (std::size_t k = 0; k < count; ++k)
        drift_rays_.push_back(
            builder_.curves().sample.starts[candidates[(2 * k + 1) * candidates.size() / (2 * count)]]);
}

/// Chooses the rays that are timed: all rays, or every fourth block of rays in a quick study.
void PointMeasurements::choose_timed_rays() {
    const std::vector<RayStart>& all = builder_.curves().sample.starts;
    for (std::size_t i = 0; i < all.size(); ++i)
        if (!options_.quick || i / rays_per_block % timed_block_interval == 0) timed_rays_.push_back(all[i]);
}

void PointMeasurements::measure(const MethodShare& share, const std::function<void(double)>& progress) {
    timed_.clear();
    const auto add_point = [&](const Variant& variant, std::size_t curve, StudyPoint& point, const RunReport& run,
                               const std::vector<RayEnd>& ends) {
        return add_timed_point(variant, curve, point, run, ends);
    };
    builder_.measure_ladders(
        progress, add_point, [&](const Variant& variant) { return restored_point(variant); }, share);
}

/// Returns the stored point of a variant, if there is one, and adds it to the timed points.
std::optional<StudyPoint> PointMeasurements::restored_point(const Variant& variant) {
    const std::vector<StudyCurve>& curves = builder_.curves().curves;
    TimedPoint timed{variant, curves.size() - 1, curves.back().points.size()};
    const auto point = restore_point(options_.store, plan(), timed);
    if (point) timed_.push_back(std::move(timed));
    return point;
}

/// Adds a point to the timed points, estimates its time and measures its energy drift. `run` and `ends` are the report
/// and the ray ends of the run that measured the errors of the point. A quick study traces the timed rays once more;
/// that run counts as the first timed run. Returns false if a run was interrupted.
bool PointMeasurements::add_timed_point(const Variant& variant, std::size_t curve, StudyPoint& point,
                                        const RunReport& run, const std::vector<RayEnd>& ends) {
    TimedPoint timed{variant, curve, builder_.curves().curves[curve].points.size(), 0, 0, step_limit_of(ends)};
    const bool quick = options_.quick;
    double seconds_with = run.seconds;  // of a run with surfaces
    std::vector<RayEnd> unused;
    if (quick) {
        const RunReport timed_run = trace(plan_for_timing(variant), timed_rays_, unused, builder_.control());
        if (timed_run.interrupted) return false;
        seconds_with = timed_run.seconds;
    }
    const Plan plan_without =
        without_surfaces(quick ? plan_for_timing(variant) : plan_with_variant(plan(), variant), timed.max_steps);
    const RunReport without = trace(plan_without, timed_rays_, unused, builder_.control());
    if (without.interrupted) return false;
    const double timed_rays = double(timed_rays_.size());
    point.steps_without_surfaces = double(without.counters.steps) / timed_rays;
    // These runs and the timed runs may have different numbers of threads.
    timed.estimate = (seconds_with + without.seconds) * plan_without.run.threads / options_.threads;
    if (quick) {
        timed.with_surfaces = {1e9 * seconds_with / timed_rays};
        timed.without_surfaces = {1e9 * without.seconds / timed_rays};
    }
    point.drift = energy_drift(plan(), variant, drift_rays_);
    keep_point(options_.store, plan(), point, timed);
    timed_.push_back(std::move(timed));
    return true;
}

}  // namespace kagero

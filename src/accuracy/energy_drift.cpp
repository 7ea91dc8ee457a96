#include "accuracy/energy_drift.h"

#include "render/trace.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

/// The level H0 of a ray, and the scale ½|p0|² + |H0| with its momentum p0 at the start. The relative energy error is
/// (H − H0)/scale.
struct Level {
    double value, scale;
};

Level level_of(const Plan& plan, const RayStart& ray) {
    const auto& formula = plan.description().space.formula;
    const double level = formula ? formula->level : plan.scene->space.info().level;
    const double kinetic = 0.5 * (ray.p[0] * ray.p[0] + ray.p[1] * ray.p[1] + ray.p[2] * ray.p[2]);
    return {level, kinetic + std::abs(level)};
}

std::vector<PathPoint> paths_of(const Plan& plan, const Variant& variant, const std::vector<RayStart>& rays) {
    std::vector<RayEnd> ends;
    return trace_paths(plan_with_variant(plan, variant), rays, ends);
}

/// Returns the mean of the values with indices begin to end − 1.
double mean(const std::vector<double>& values, std::size_t begin, std::size_t end) {
    double sum = 0;
    for (std::size_t i = begin; i < end; ++i) sum += values[i];
    return sum / double(end - begin);
}

/// Returns the energy drift of one ray. `errors` contains |H − H0|/scale at each step; it is not empty.
EnergyDrift drift_of(const std::vector<double>& errors) {
    const std::size_t n = errors.size(), tenth = std::max<std::size_t>(1, n / 10);
    return {*std::max_element(errors.begin(), errors.end()), mean(errors, 0, tenth), mean(errors, n - tenth, n)};
}

}  // namespace

EnergyDrift energy_drift(const Plan& plan, const Variant& variant, const std::vector<RayStart>& rays) {
    const std::vector<PathPoint> points = paths_of(plan, variant, rays);
    EnergyDrift worst;
    for (auto path_begin = points.begin(); path_begin != points.end();) {
        const std::uint64_t ray = path_begin->ray;
        const auto path_end =
            std::find_if(path_begin, points.end(), [&](const PathPoint& point) { return point.ray != ray; });
        const Level level = level_of(plan, rays[ray]);
        std::vector<double> errors;
        // The first point is the ray start, where H equals H0 to rounding. It is left out if other points exist.
        for (auto point = path_begin + (path_end - path_begin > 1); point != path_end; ++point)
            if (std::isfinite(point->energy)) errors.push_back(std::abs(point->energy - level.value) / level.scale);
        if (!errors.empty()) {
            const EnergyDrift drift = drift_of(errors);
            worst.max = std::max(worst.max, drift.max);
            worst.first_tenth = std::max(worst.first_tenth, drift.first_tenth);
            worst.last_tenth = std::max(worst.last_tenth, drift.last_tenth);
        }
        path_begin = path_end;
    }
    return worst;
}

EnergyTrace energy_trace(const Plan& plan, const Variant& variant, const RayStart& ray) {
    const IntegratorInfo& info = info_of(plan, variant);
    EnergyTrace trace{&info, stated_step(plan, variant), 0, {}};
    const Level level = level_of(plan, ray);
    for (const PathPoint& point : paths_of(plan, variant, {ray}))
        if (std::isfinite(point.energy))
            trace.points.push_back({point.parameter, (point.energy - level.value) / level.scale});
    return trace;
}

}  // namespace kagero

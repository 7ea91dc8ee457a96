#include "tuning/precision.h"

#include "accuracy/ray_errors.h"
#include "pixels/shade.h"
#include "plan/names.h"
#include "rays/camera.h"
#include "render/trace.h"

#include <cmath>

namespace kagero {
namespace {

/// Rays along an edge of the grid.
constexpr std::uint32_t trial_grid = 32;
/// A picture with fewer rays than some times those of the trial is not worth one.
constexpr double worthwhile = 16.0 * trial_grid * trial_grid;
/// The greatest difference of 99 % of the rays, in pixels: too small to be seen, or to add to the error of the method.
constexpr double most_apart = 0.1;
/// The share that may end otherwise, or more than a pixel off: rays that graze an edge, or circle before they leave.
constexpr double most_strays = 0.003;
/// Below this tolerance float's rounding is what an adaptive method would try to control.
constexpr double least_float_tolerance = 5e-7;
/// Float gains nothing where it needs so many more steps.
constexpr double most_extra_steps = 1.2;

/// The reason for double that is known before any ray is traced; empty if there is none.
std::string plain_reason(const Plan& plan) {
    const FilmDescription& film = plan.description().film;
    if (plan.run.wish.precision) return std::string("--precision ") + name_of(*plan.run.wish.precision);
    if (plan.run.kernel->strategy != Strategy::packet) return "one ray at a time is hardly quicker in float";
    for (const std::string& layer : film.layers) {
        if (needs_of(layer) & need_any_error) return "float would be most of what layer " + layer + " shows";
        if (needs_of(layer) & need_footprint)
            return "layer " + layer + " shows differences of neighbours, and of their roundings in float";
    }
    if (plan.method().adaptive && !plan.scene->straight && plan.run.tolerance < least_float_tolerance)
        return "integrator.tolerance is below what float can hold";
    if (double(film.width) * film.height * film.spp < worthwhile) return "so small a picture gains nothing";
    return {};
}

std::vector<RayEnd> ends_of(const Plan& plan, const std::vector<RayStart>& starts) {
    std::vector<RayEnd> ends;
    trace(plan, starts, ends);
    for (RayEnd& end : ends) end = in_space(plan, end);
    return ends;
}

double total_steps(const std::vector<RayEnd>& ends) {
    double steps = 0;
    for (const RayEnd& end : ends) steps += end.steps;
    return steps;
}

/// Null where there is none.
const KernelInfo* kernel_in_float(const Plan& plan) {
    KernelWish wish = plan.run.wish;
    wish.precision = Precision::float32;
    return find_kernel(*plan.scene, plan.run.method, wish);
}

/// The reason for double in the ends of rays that are traced in both precisions; empty if there is none.
std::string measured_reason(const Plan& plan, const Plan& plan_in_float, PrecisionTrial& trial) {
    std::vector<RayStart> starts;
    for (const auto& [x, y] : sample_pixels(plan.description().film, trial_grid, trial_grid))
        starts.push_back(film_ray(plan, x, y));
    const std::vector<RayEnd> in_double = ends_of(plan, starts), in_float = ends_of(plan_in_float, starts);
    std::vector<double> apart;
    std::size_t strays = 0;
    for (std::size_t i = 0; i < in_double.size(); ++i) {
        if (in_double[i].status == in_float[i].status && !has_end(in_double[i])) continue;
        const double error = pixel_error(plan, in_double[i], in_float[i]);
        if (std::isnan(error) || error > 1) ++strays;
        if (!std::isnan(error)) apart.push_back(error);
    }
    trial.rays = in_double.size();
    if (!apart.empty()) trial.apart = spread_of(std::move(apart)).p99;
    if (double(strays) > most_strays * double(trial.rays))
        return std::to_string(strays) + " of " + std::to_string(trial.rays) + " rays end elsewhere in float";
    if (!(trial.apart <= most_apart)) return "float is more than a tenth of a pixel from double";
    if (total_steps(in_float) > most_extra_steps * total_steps(in_double)) return "float needs more steps than double";
    return {};
}

}  // namespace

Plan choose_precision(Plan plan) {
    if (plan.run.wish.precision == Precision::float32) return plan;
    PrecisionTrial trial;
    trial.why_not = plain_reason(plan);
    if (trial.why_not.empty()) {
        Plan in_float = plan;
        in_float.run.kernel = kernel_in_float(plan);
        if (!in_float.run.kernel) trial.why_not = "no kernel in float serves the method and integrator.lanes";
        else if (camera_needs_double(*plan.scene, plan.view))
            trial.why_not = "so near a horizon float cannot hold the momentum";
        else trial.why_not = measured_reason(plan, in_float, trial);
        if (trial.why_not.empty()) plan.run.kernel = in_float.run.kernel;
    }
    const bool taken = trial.why_not.empty();
    plan.decisions.tuning.push_back({taken ? "float: 99 % of " + std::to_string(trial.rays) + " rays ended within " +
                                                 plain_number(trial.apart) + " pixels of where double ends them"
                                           : "float",
                                     taken, trial.why_not});
    plan.precision_trial = trial;
    return plan;
}

}  // namespace kagero

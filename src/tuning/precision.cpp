#include "tuning/precision.h"

#include "accuracy/ray_errors.h"
#include "error.h"
#include "pixels/shade.h"
#include "plan/names.h"
#include "rays/camera.h"
#include "render/trace.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

/// Number of rays along each edge of the trial's grid.
constexpr std::uint32_t trial_grid = 32;
/// Smallest number of rays in a picture for which a trial is worthwhile.
constexpr double min_picture_rays = 16.0 * trial_grid * trial_grid;
/// Greatest permitted 99th percentile of the differences between ray ends in float and in double, in pixels. Smaller
/// differences are invisible, and small compared with the error of the method.
constexpr double max_difference = 0.1;
/// Greatest share of strays: rays whose ends in float and in double differ in status or object, or by more than one
/// pixel. Such rays graze an edge, or orbit a hole before they escape.
constexpr double max_stray_share = 0.003;
/// Greatest number of steps in float, divided by that in double. With more steps, float is not faster.
constexpr double max_step_ratio = 1.2;

/// Returns the reason to use double that is known without a trial; empty if there is none.
std::string reason_without_trial(const Plan& plan) {
    const FilmDescription& film = plan.description().film;
    if (const auto& requested = plan.run.kernel_request.precision)
        return std::string("--precision ") + name_of(*requested);
    if (plan.run.kernel->strategy != Strategy::packet)
        return std::string("strategy ") + name_of(plan.run.kernel->strategy) + " is hardly faster in float";
    for (const std::string& layer : film.layers) {
        if (needs_of(layer) & need_any_error) return "the rounding errors of float would dominate layer " + layer;
        if (needs_of(layer) & need_footprint)
            return "layer " + layer + " shows differences between neighbouring rays, which are inaccurate in float";
    }
    if (plan.method().adaptive && !plan.scene->straight && plan.run.tolerance < min_float_tolerance)
        return "the tolerance " + plain_number(plan.run.tolerance) + " is below " + plain_number(min_float_tolerance) +
               ", the smallest that step control in float can meet";
    if (double(film.width) * film.height * film.spp < min_picture_rays)
        return "the picture has fewer than " + plain_number(min_picture_rays) + " rays, too few for a trial";
    return {};
}

/// Traces the rays and returns their ends in the coordinates of the Hamiltonian.
std::vector<RayEnd> ends_of(const Plan& plan, const std::vector<RayStart>& starts, const std::atomic<bool>* stop) {
    std::vector<RayEnd> ends;
    if (trace(plan, starts, ends, {.stop = stop}).interrupted) throw Interrupted();
    for (RayEnd& end : ends) end = to_hamiltonian_coordinates(plan, end);
    return ends;
}

/// Returns the number of steps of all rays.
double total_steps(const std::vector<RayEnd>& ends) {
    double steps = 0;
    for (const RayEnd& end : ends) steps += end.steps;
    return steps;
}

/// Returns the float kernel for the plan's method and the requested strategy and lanes; null if there is none.
const KernelInfo* kernel_in_float(const Plan& plan) {
    KernelRequest request = plan.run.kernel_request;
    request.precision = Precision::float32;
    return find_kernel(*plan.scene, plan.run.method, request);
}

/// Returns the greatest permitted 99th percentile of the difference: the part of the bound on the pixel error that the
/// method leaves, if a trial has chosen the method.
double permitted_difference(const Plan& plan) {
    const auto& trial = plan.method_trial;
    return trial && trial->bound_met ? std::min(max_difference, trial->bound - trial->estimate) : max_difference;
}

/// Traces the trial's rays in both precisions. Returns the reason to use double that follows from the ray ends; empty
/// if there is none.
std::string reason_from_trial(const Plan& plan, const Plan& plan_in_float, PrecisionTrial& trial,
                              const std::atomic<bool>* stop) {
    std::vector<RayStart> starts;
    for (const auto& [x, y] : sample_pixels(plan.description().film, trial_grid, trial_grid))
        starts.push_back(camera_ray_start(plan, x, y));
    const std::vector<RayEnd> in_double = ends_of(plan, starts, stop), in_float = ends_of(plan_in_float, starts, stop);
    std::vector<double> differences;
    std::size_t strays = 0;
    for (std::size_t i = 0; i < in_double.size(); ++i) {
        if (in_double[i].status == in_float[i].status && !has_visible_end(in_double[i])) continue;
        const double difference = pixel_error(plan, in_double[i], in_float[i]);
        if (std::isnan(difference) || difference > 1) ++strays;
        if (!std::isnan(difference)) differences.push_back(difference);
    }
    trial.rays = in_double.size();
    if (!differences.empty()) trial.difference = percentiles_of(std::move(differences)).p99;
    if (double(strays) > max_stray_share * double(trial.rays))
        return std::to_string(strays) + " of " + std::to_string(trial.rays) +
               " rays have another status or object in float, or end more than a pixel away; at most " +
               plain_number(100 * max_stray_share) + " % may";
    const double permitted = permitted_difference(plan);
    if (!(trial.difference <= permitted))
        return "the 99th percentile of the difference between float and double is " + plain_number(trial.difference) +
               " pixels; at most " + plain_number(permitted) + " is permitted";
    const double step_ratio = total_steps(in_float) / total_steps(in_double);
    if (step_ratio > max_step_ratio)
        return "float needs " + plain_number(std::round(100 * step_ratio) / 100) + " times as many steps as double";
    return {};
}

}  // namespace

Plan choose_precision(Plan plan, const std::atomic<bool>* stop) {
    if (plan.run.kernel_request.precision == Precision::float32) return plan;
    PrecisionTrial trial;
    trial.reason_for_double = reason_without_trial(plan);
    if (trial.reason_for_double.empty()) {
        Plan in_float = plan;
        in_float.run.kernel = kernel_in_float(plan);
        if (!in_float.run.kernel) trial.reason_for_double = "no float kernel supports the method and integrator.lanes";
        else if (camera_needs_double(*plan.scene, plan.view))
            trial.reason_for_double = "the momentum of a camera this close to a horizon is too large for float";
        else trial.reason_for_double = reason_from_trial(plan, in_float, trial, stop);
        if (trial.reason_for_double.empty()) plan.run.kernel = in_float.run.kernel;
    }
    const bool use_float = trial.reason_for_double.empty();
    plan.decisions.tuning.push_back({use_float ? "float: for 99 % of " + std::to_string(trial.rays) +
                                                     " rays, its difference from double is at most " +
                                                     plain_number(trial.difference) + " pixels"
                                               : "float",
                                     use_float, trial.reason_for_double});
    plan.precision_trial = trial;
    return plan;
}

}  // namespace kagero

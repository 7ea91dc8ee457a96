#include "accuracy/end_errors.h"

#include "accuracy/ray_errors.h"
#include "accuracy/rounding_bounds.h"
#include "pixels/shade.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

/// Method of the second run in spaces that bound the step: adaptive, of order 8.
constexpr const char* substitute_method = "dp85";
/// Tolerance of `substitute_method`. The second run must be much more accurate than the picture.
constexpr double substitute_tolerance = 1e-10;
/// Smallest tolerance that adaptive methods can meet in double precision.
constexpr double least_tolerance = 1e-14;
/// Ratio of the tolerances of both runs if both use the plan's adaptive method.
constexpr double tolerance_ratio = 100;

/// Returns the tolerance of the second run: a smaller one if adaptive methods can meet it, otherwise a larger one.
double second_tolerance(double tolerance) {
    return tolerance >= tolerance_ratio * least_tolerance ? tolerance / tolerance_ratio : tolerance * tolerance_ratio;
}

/// Returns the double-precision kernel of the plan's strategy and form, or the plan's kernel if no such kernel supports
/// the scene.
const KernelInfo& float64_kernel(const Plan& plan) {
    const KernelInfo& plan_kernel = *plan.run.kernel;
    for (std::uint32_t i = 0; i < plan.module().kernel_count; ++i) {
        const KernelInfo& kernel = plan.module().kernels[i];
        if (kernel.precision == Precision::float64 && kernel.strategy == plan_kernel.strategy &&
            kernel.form == plan_kernel.form && !refusal_of(*plan.scene, kernel, plan.run.method))
            return kernel;
    }
    return plan_kernel;
}

/// Returns the plan of the second run in one space, which traces in double and, if rays bend, with shorter steps.
/// `error_over_difference` is increased to the position error divided by the distance between the ends in both runs.
Plan refined(const Plan& plan, double& error_over_difference) {
    const IntegratorInfo& info = plan.method();
    const Variant same_method = variant_with_kernel(plan, float64_kernel(plan));
    if (plan.scene->straight) return plan_with_variant(plan, same_method);
    const double step = same_method.step;
    // The substitute is not used if the plan's tolerance is almost as small as that of the substitute.
    const bool is_tolerance_small = info.adaptive && step <= tolerance_ratio * substitute_tolerance;
    const auto substitute = plan.scene->space.info().bounds_steps && !is_tolerance_small
                                ? find_variant(plan, substitute_method, *same_method.kernel, substitute_tolerance)
                                : std::nullopt;
    Variant second = substitute.value_or(same_method);
    second.solver_tolerance = 0;
    // The first step of an adaptive method is halved too. The error of the second run is assumed to be smaller by the
    // ratio of the tolerances or by 2^order, whichever is less.
    const bool halves_first_step = !substitute && info.adaptive && second_tolerance(step) < step;
    if (!substitute) {
        second.step = info.adaptive ? second_tolerance(step) : 0.5 * step;
        // Hits on chords have an error of second order in the step, whatever the order of the method.
        const bool chords = plan.scene->geometry->kernel_view() && plan.run.hit == HitModel::chord;
        const double order = info.adaptive ? 1 : chords ? std::min(2.0, double(info.order)) : info.order;
        double error_ratio = std::pow(second.step / step, order);
        if (halves_first_step) error_ratio = std::max(error_ratio, std::pow(0.5, info.order));
        error_over_difference = std::max(error_over_difference, 1 / std::abs(1 - error_ratio));
    }
    Plan second_run = plan_with_variant(plan, second);
    if (halves_first_step) second_run.run.step *= 0.5;
    // The substitute takes longer steps than the plan's method, so hits on its chords would be less accurate.
    if (substitute) second_run.run.hit = HitModel::hermite;
    return second_run;
}

/// Returns true if the ends of rays have errors other than the rounding of the ends themselves: if rays bend, or if
/// they continue at surfaces.
bool have_errors_on_the_way(const Plan& plan) {
    return !plan.scene->straight || plan.run.max_bounces || plan.view.medium != 0;
}

}  // namespace

EndErrors::EndErrors(const Plan& plan, bool position, bool rounding)
    : plan_(plan), estimates_position_(position), estimates_rounding_(rounding) {
    if (!position || !have_errors_on_the_way(plan)) return;
    second_run_ = refined(plan, error_over_difference_);
    for (auto& medium : second_run_->media) medium = refined(medium, error_over_difference_);
}

/// Returns the error, in pixels, of rounding the ray end to the plan's precision. Smaller errors cannot be measured.
double EndErrors::end_rounding_error(const RayEnd& end) const {
    if (!has_visible_end(end)) return 0;
    const double epsilon = plan_.run.kernel->precision == Precision::float32 ? 0x1p-24 : 0x1p-53;
    if (end.status == Status::escaped) return epsilon / pixel_size(plan_.description(), 1);
    return epsilon * std::hypot(end.q[0], end.q[1], end.q[2]) / pixel_size_at(plan_, end);
}

std::vector<EndError> EndErrors::estimate(const Tile& tile, const TracedRays& rays, const CancelToken& cancel) const {
    const std::vector<RayEnd>& ends = rays.ends;
    std::vector<EndError> errors;
    if (!estimates_position_ && !estimates_rounding_) return errors;
    const std::size_t count = ends.size();
    for (std::size_t i = 0; i < count; ++i)
        errors.push_back({end_rounding_error(ends[i]), end_rounding_error(ends[i])});
    if (second_run_) {
        TracedRays second{rays.list, {}, {}, {}, {}};
        PathCounters unused;
        const Job job = second_run_->medium(plan_.view.medium).job();
        trace_paths(*second_run_, job, tile, branch_choice_of(plan_), second, unused, cancel);
        for (std::size_t i = 0; i < count; ++i) {
            const bool is_same_path = rays.paths.empty() || rays.paths[i].surfaces == second.paths[i].surfaces;
            const double difference =
                is_same_path ? pixel_error(plan_, second.ends[i], ends[i]) : std::numeric_limits<double>::quiet_NaN();
            errors[i].position =
                std::isnan(difference) ? difference : std::max(errors[i].position, error_over_difference_ * difference);
        }
    }
    if (estimates_rounding_) {
        std::vector<double> bounds(count, std::numeric_limits<double>::quiet_NaN());
        if (plan_.view.medium == 0) bounds = rounding_bounds(plan_, tile, ends.data(), rays.list, cancel);
        for (std::size_t i = 0; i < count; ++i)  // the bound does not reach beyond the first surface
            errors[i].rounding =
                rays.paths.empty() || rays.paths[i].bounces == 0 ? bounds[i] : std::numeric_limits<double>::quiet_NaN();
    }
    return errors;
}

RunReport render_with_errors(const Plan& plan, Film& film, const RunControl& control) {
    const unsigned needs = needs_of(film);
    if (!(needs & (need_position_error | need_rounding_error))) return render(plan, film, control);
    const EndErrors errors(plan, needs & need_position_error, needs & need_rounding_error);
    const auto estimate = [&](const Tile& tile, const TracedRays& rays, const CancelToken& cancel) {
        return errors.estimate(tile, rays, cancel);
    };
    return render(plan, film, control, estimate);
}

}  // namespace kagero

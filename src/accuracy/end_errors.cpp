#include "accuracy/end_errors.h"

#include "accuracy/ray_errors.h"
#include "accuracy/rounding_bounds.h"
#include "pixels/shade.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

/// A method of order 8, for spaces that bound steps themselves; an error far below any that is asked for.
constexpr const char* partner_method = "dp85";
constexpr double partner_tolerance = 1e-10;
/// Adaptive methods reach no less.
constexpr double least_tolerance = 1e-14, tolerance_ratio = 100;

/// A tolerance to compare with: a smaller one, or a larger one where adaptive methods reach no less.
double other_tolerance(double tolerance) {
    return tolerance >= tolerance_ratio * least_tolerance ? tolerance / tolerance_ratio : tolerance * tolerance_ratio;
}

/// The plan's kernel, in double.
const KernelInfo& in_double(const Plan& plan) {
    const KernelInfo& own = *plan.run.kernel;
    for (std::uint32_t i = 0; i < plan.module().kernel_count; ++i) {
        const KernelInfo& kernel = plan.module().kernels[i];
        if (kernel.precision == Precision::float64 && kernel.strategy == own.strategy && kernel.form == own.form &&
            !refusal_of(*plan.scene, kernel, plan.run.method))
            return kernel;
    }
    return own;
}

}  // namespace

EndErrors::EndErrors(const Plan& plan, bool position, bool rounding)
    : plan_(plan), position_(position), rounding_(rounding) {
    if (plan.scene->straight || !position) return;
    const IntegratorInfo& info = plan.method();
    const Variant own = own_variant(plan, in_double(plan));
    const bool bounded = plan.scene->space.info().bounds_steps,
               close = info.adaptive && own.step <= tolerance_ratio * partner_tolerance;
    const auto partner =
        bounded && !close ? find_variant(plan, partner_method, *own.kernel, partner_tolerance) : std::nullopt;
    Variant finer = partner.value_or(own);
    finer.solver_tolerance = 0;
    // The longest step of adaptive methods may govern as well as their tolerance.
    const bool shorter = !partner && info.adaptive && other_tolerance(own.step) < own.step;
    if (!partner) {
        finer.step = info.adaptive ? other_tolerance(own.step) : 0.5 * own.step;
        // Hits on chords are of second order, whatever the method.
        const bool chords = plan.scene->geometry->kernel_view() && plan.run.hit == HitModel::chord;
        const double order = info.adaptive ? 1 : chords ? std::min(2.0, double(info.order)) : info.order;
        double less = std::pow(finer.step / own.step, order);
        if (shorter) less = std::max(less, std::pow(0.5, info.order));
        error_over_difference_ = 1 / std::abs(1 - less);
    }
    finer_ = plan_by(plan, finer);
    if (shorter) finer_->run.step *= 0.5;
    if (partner)
        finer_->run.hit = HitModel::hermite;  // its long steps are farther from their chords than the picture's
}

/// Numbers of this precision tell ends apart no better.
double EndErrors::least_error(const RayEnd& end) const {
    if (!has_end(end)) return 0;
    const double epsilon = plan_.run.kernel->precision == Precision::float32 ? 0x1p-24 : 0x1p-53;
    if (end.status == Status::escaped) return epsilon / pixel_size(plan_.description(), 1);
    return epsilon * std::hypot(end.q[0], end.q[1], end.q[2]) / pixel_at(plan_, end);
}

std::vector<EndError> EndErrors::of(const Tile& tile, const RayEnd* ends, const RayList& list, const Halt& halt) const {
    std::vector<EndError> errors;
    if (!position_ && !rounding_) return errors;
    const std::size_t count = rays_of(tile, list);
    for (std::size_t i = 0; i < count; ++i) errors.push_back({least_error(ends[i]), least_error(ends[i])});
    if (finer_) {
        std::vector<RayEnd> others;
        Counters unused{};
        Job job = finer_->job();
        halt.tell(job);
        trace_tile(*finer_->run.kernel, job, tile, list, others, unused);
        for (std::size_t i = 0; i < count; ++i) {
            const double difference = pixel_error(plan_, others[i], ends[i]);
            errors[i].position =
                std::isnan(difference) ? difference : std::max(errors[i].position, error_over_difference_ * difference);
        }
    }
    if (rounding_) {
        const std::vector<double> bounds = rounding_bounds(plan_, tile, ends, list, halt);
        for (std::size_t i = 0; i < count; ++i) errors[i].rounding = bounds[i];
    }
    return errors;
}

RunReport render_with_errors(const Plan& plan, Film& film, const Watch& watch) {
    const unsigned needs = needs_of(film);
    if (!(needs & (need_position_error | need_rounding_error))) return render(plan, film, watch);
    const EndErrors errors(plan, needs & need_position_error, needs & need_rounding_error);
    return render(plan, film, watch, [&](const Tile& tile, const RayEnd* ends, const RayList& list, const Halt& halt) {
        return errors.of(tile, ends, list, halt);
    });
}

}  // namespace kagero

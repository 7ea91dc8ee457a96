#include "accuracy/step_ladder.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

/// Highest order of the fixed-step methods that are measured in float. With a higher order, rounding limits the error
/// at every useful step.
constexpr std::uint32_t highest_float_order = 4;

/// Tolerances of adaptive methods, in double and in float.
constexpr double tolerances[] = {1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13},
                 float_tolerances[] = {1e-2, 1e-3, 1e-4, 1e-5, 1e-6};
/// Number of times that the coarsest step is halved.
constexpr std::size_t halvings = 9;
/// Numbers of step sizes per ladder with LadderChoice::quick: at most `quick_scalar_steps` with the strategy `scalar`,
/// and at least `quick_loose_steps` with a loose solver tolerance.
constexpr std::size_t quick_scalar_steps = 3, quick_loose_steps = 3;

/// Returns the coarsest step of a ladder: 1, 2, 4 or 8 times the plan's step, or times the space's default step if
/// `seeks_cheapest` is set. The factor is greater for methods of higher order. It is also greater for methods that do
/// not support the plan's time rescaling, because a fixed step is shorter than necessary far from the centre.
double coarsest_step(const Plan& plan, const Variant& variant, bool seeks_cheapest) {
    const std::uint32_t order = info_of(plan, variant).order;
    const double doublings = (order >= 8   ? 2
                              : order >= 4 ? 1
                                           : 0) +
                             (plan.run.method.rescaled && !variant.method.rescaled ? 1 : 0);
    return (seeks_cheapest ? default_step(plan, variant) : equivalent_step(plan, variant)) * std::exp2(doublings);
}

/// Returns the steps or tolerances of a ladder, the coarsest first. For straight rays, the ladder has a single step,
/// which has no effect.
std::vector<double> ladder_steps(const Plan& plan, const Variant& variant, bool seeks_cheapest) {
    const IntegratorInfo& info = info_of(plan, variant);
    if (plan.scene->straight) return {plan.run.step};
    if (info.adaptive && variant.kernel->precision == Precision::float32)
        return {std::begin(float_tolerances), std::end(float_tolerances)};
    if (info.adaptive) {
        std::vector<double> sorted(std::begin(tolerances), std::end(tolerances));
        if (&info == &plan.method() && std::count(sorted.begin(), sorted.end(), plan.run.tolerance) == 0)
            sorted.push_back(plan.run.tolerance);
        std::sort(sorted.begin(), sorted.end(), std::greater<>());
        return sorted;
    }
    std::vector<double> steps{coarsest_step(plan, variant, seeks_cheapest)};
    for (std::size_t i = 0; i < halvings; ++i) steps.push_back(0.5 * steps.back());
    return steps;
}

/// Properties of a group of ladders.
struct LadderKind {
    Strategy strategy;
    Precision precision;
    bool has_loose_solver = false;
};
/// All groups, in the order of measurement.
constexpr LadderKind ladder_kinds[] = {
    {Strategy::packet, Precision::float64}, {Strategy::packet, Precision::float64, true},
    {Strategy::packet, Precision::float32}, {Strategy::scalar, Precision::float64},
    {Strategy::scalar, Precision::float32},
};

/// Returns true if the ladder of a method in this group is measured.
bool is_selected(const Plan& plan, const IntegratorInfo& info, const LadderKind& kind, const LadderChoice& choice,
                 bool is_scene_method) {
    if (choice.strategy && *choice.strategy != kind.strategy) return false;
    if (choice.precision && *choice.precision != kind.precision) return false;
    if (info.angular && !plan.run.use_symmetry) return false;
    if (kind.has_loose_solver && (!info.implicit || plan.scene->straight || plan.run.solver_tolerance > 0))
        return false;
    if (kind.precision == Precision::float32 && info.order > highest_float_order && !info.adaptive && !is_scene_method)
        return false;
    if (kind.precision == Precision::float32 && choice.quick && !choice.seeks_cheapest && !is_scene_method)
        return false;
    return kind.strategy == Strategy::packet || is_scene_method || choice.full || choice.strategy;
}

}  // namespace

std::vector<Ladder> choose_ladders(const Plan& plan, const LadderChoice& choice, std::vector<std::string>& refused) {
    const std::string scene_method = plan.method().name;
    const auto method_selected = [&](const IntegratorInfo& info) {
        if (plan.scene->straight) return info.name == scene_method;
        return !choice.quick || info.name == scene_method || info.representative;
    };
    std::vector<Ladder> ladders;
    for (const LadderKind& kind : ladder_kinds)
        for (std::uint32_t i = 0; i < plan.module().integrator_count; ++i) {
            const IntegratorInfo& info = plan.module().integrators[i];
            if (!method_selected(info) || !is_selected(plan, info, kind, choice, info.name == scene_method)) continue;
            const auto variant = find_variant(plan, info.name, kind.strategy, kind.precision, 0);
            if (!variant) {
                if (std::count(refused.begin(), refused.end(), info.name) == 0) refused.push_back(info.name);
                continue;
            }
            Ladder& ladder = ladders.emplace_back();
            ladder.variant = *variant;
            ladder.is_scene_method = info.name == scene_method;
            ladder.has_loose_solver = kind.has_loose_solver;
            ladder.steps = ladder_steps(plan, *variant, choice.seeks_cheapest);
            if (choice.quick && kind.has_loose_solver) ladder.min_steps = quick_loose_steps;
            // Runs with the strategy `scalar` have the same errors as packets and differ only in time. They are slow,
            // so only a few step sizes are measured.
            if (choice.quick && kind.strategy == Strategy::scalar && ladder.steps.size() > quick_scalar_steps)
                ladder.steps.resize(quick_scalar_steps);
        }
    return ladders;
}

LadderFit fit_ladder(const std::vector<double>& steps, const std::vector<double>& errors, double nominal_order,
                     double scene_size) {
    LadderFit fit;
    for (const double error : errors)
        if (!std::isnan(error) && !(fit.floor && *fit.floor <= error)) fit.floor = error;
    // The order is fitted in the asymptotic range of steps, which excludes errors near the size of the scene. A step
    // whose local slope is below 3/4 of the nominal order ends the range, because rounding dominates there. If the
    // range has fewer than two points, it begins again at that step. The fit uses the finest steps of the range.
    const double max_error = 0.1 * scene_size;
    std::vector<std::array<double, 2>> asymptotic;
    for (std::size_t i = 0; i < errors.size(); ++i) {
        if (!(errors[i] > 0) || errors[i] > max_error) continue;
        const std::array<double, 2> point{std::log(steps[i]), std::log(errors[i])};
        const bool converges =
            asymptotic.empty() ||
            (point[1] - asymptotic.back()[1]) / (point[0] - asymptotic.back()[0]) > 0.75 * nominal_order;
        if (!converges && asymptotic.size() >= 2) break;
        if (!converges) asymptotic.clear();
        asymptotic.push_back(point);
    }
    constexpr std::size_t max_points = 3;
    if (asymptotic.size() > max_points) asymptotic.erase(asymptotic.begin(), asymptotic.end() - max_points);
    if (asymptotic.size() < 2) return fit;
    double x = 0, y = 0, xx = 0, xy = 0;
    const double n = double(asymptotic.size());
    for (const auto& [log_step, log_error] : asymptotic) {
        x += log_step;
        y += log_error;
        xx += log_step * log_step;
        xy += log_step * log_error;
    }
    fit.order = (n * xy - x * y) / (n * xx - x * x);
    return fit;
}

}  // namespace kagero

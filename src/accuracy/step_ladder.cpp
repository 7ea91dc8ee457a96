#include "accuracy/step_ladder.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

/// Beyond this order a method buys nothing before float is exhausted.
constexpr std::uint32_t highest_float_order = 4;

constexpr double tolerances[] = {1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13},
                 float_tolerances[] = {1e-2, 1e-3, 1e-4, 1e-5, 1e-6};
constexpr std::size_t most_halvings = 9, quick_scalar_steps = 3, quick_loose_steps = 3;

/// Higher orders take longer steps, and so do methods that cannot have the plan's rescaled H: far out their steps are
/// many. A step that the scene states is no place to begin a search for another.
double coarsest_step(const Plan& plan, const Variant& variant, bool seeks_cheapest) {
    const std::uint32_t order = info_of(plan, variant).order;
    const double doublings = (order >= 8   ? 2
                              : order >= 4 ? 1
                                           : 0) +
                             (plan.run.method.rescaled && !variant.method.rescaled ? 1 : 0);
    return (seeks_cheapest ? default_step(plan, variant) : usual_step(plan, variant)) * std::exp2(doublings);
}

std::vector<double> steps_of(const Plan& plan, const Variant& variant, bool seeks_cheapest) {
    const IntegratorInfo& info = info_of(plan, variant);
    if (plan.scene->straight) return {plan.run.step};
    if (info.adaptive && variant.kernel->precision == Precision::float32)
        return {std::begin(float_tolerances), std::end(float_tolerances)};
    if (info.adaptive) {
        std::vector<double> all(std::begin(tolerances), std::end(tolerances));
        if (&info == &plan.method() && std::count(all.begin(), all.end(), plan.run.tolerance) == 0)
            all.push_back(plan.run.tolerance);
        std::sort(all.begin(), all.end(), std::greater<>());
        return all;
    }
    std::vector<double> steps{coarsest_step(plan, variant, seeks_cheapest)};
    for (std::size_t i = 0; i < most_halvings; ++i) steps.push_back(0.5 * steps.back());
    return steps;
}

struct LadderKind {
    Strategy strategy;
    Precision precision;
    bool loose = false;
};
constexpr LadderKind ladder_kinds[] = {
    {Strategy::packet, Precision::float64},
    {Strategy::packet, Precision::float64, true},
    {Strategy::packet, Precision::float32},
    {Strategy::scalar, Precision::float64},
    {Strategy::scalar, Precision::float32},
};

bool worth_it(const Plan& plan, const IntegratorInfo& info, const LadderKind& kind, const LadderChoice& choice,
              bool own) {
    if (choice.strategy && *choice.strategy != kind.strategy) return false;
    if (choice.precision && *choice.precision != kind.precision) return false;
    if (info.angular && !plan.run.use_symmetry) return false;
    if (kind.loose && (!info.implicit || plan.scene->straight || plan.run.solver_tolerance > 0)) return false;
    if (kind.precision == Precision::float32 && info.order > highest_float_order && !info.adaptive && !own)
        return false;
    if (kind.precision == Precision::float32 && choice.quick && !choice.seeks_cheapest && !own) return false;
    return kind.strategy == Strategy::packet || own || choice.full || choice.strategy;
}

}  // namespace

std::vector<Ladder> choose_ladders(const Plan& plan, const LadderChoice& choice, std::vector<std::string>& refused) {
    const std::string own = plan.method().name;
    const auto wanted = [&](const IntegratorInfo& info) {
        if (plan.scene->straight) return info.name == own;
        return !choice.quick || info.name == own || info.typical;
    };
    std::vector<Ladder> ladders;
    for (const LadderKind& kind : ladder_kinds)
        for (std::uint32_t i = 0; i < plan.module().integrator_count; ++i) {
            const IntegratorInfo& info = plan.module().integrators[i];
            if (!wanted(info) || !worth_it(plan, info, kind, choice, info.name == own)) continue;
            const auto variant = find_variant(plan, info.name, kind.strategy, kind.precision, 0);
            if (!variant) {
                if (std::count(refused.begin(), refused.end(), info.name) == 0) refused.push_back(info.name);
                continue;
            }
            Ladder& ladder = ladders.emplace_back();
            ladder.variant = *variant, ladder.own = info.name == own, ladder.loose = kind.loose;
            ladder.steps = steps_of(plan, *variant, choice.seeks_cheapest);
            if (choice.quick && kind.loose) ladder.least = quick_loose_steps;
            // One ray at a time nothing but the time is new, and there is much of it.
            if (choice.quick && kind.strategy == Strategy::scalar && ladder.steps.size() > quick_scalar_steps)
                ladder.steps.resize(quick_scalar_steps);
        }
    return ladders;
}

Slope slope_of(const std::vector<double>& steps, const std::vector<double>& errors, double stated_order,
               double scene_size) {
    Slope slope;
    for (const double error : errors)
        if (!std::isnan(error) && !(slope.floor && *slope.floor <= error)) slope.floor = error;
    // Errors near the size of the scene follow no power of the step, and below the last step that still gains what the
    // order promises rounding shows. Of what lies between, the finest steps are the nearest to the limit that defines
    // an order.
    const double greatest = 0.1 * scene_size;
    std::vector<std::array<double, 2>> above;
    for (std::size_t i = 0; i < errors.size(); ++i) {
        if (!(errors[i] > 0) || errors[i] > greatest) continue;
        const std::array<double, 2> point{std::log(steps[i]), std::log(errors[i])};
        const bool gains =
            above.empty() || (point[1] - above.back()[1]) / (point[0] - above.back()[0]) > 0.75 * stated_order;
        if (!gains && above.size() >= 2) break;
        if (!gains) above.clear();
        above.push_back(point);
    }
    constexpr std::size_t most = 3;
    if (above.size() > most) above.erase(above.begin(), above.end() - most);
    if (above.size() < 2) return slope;
    double x = 0, y = 0, xx = 0, xy = 0;
    const double n = double(above.size());
    for (const auto& [a, b] : above) x += a, y += b, xx += a * a, xy += a * b;
    slope.order = (n * xy - x * y) / (n * xx - x * x);
    return slope;
}

}  // namespace kagero

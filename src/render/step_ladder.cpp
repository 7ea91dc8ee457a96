#include "render/step_ladder.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

/// The recipe as printed, its symmetric cure, and what rivals them; the scene's own method joins them.
constexpr const char* quick_methods[] = {"satoh2", "satoh4", "verlet", "suzuki4-nine", "rk4", "dp54", "gauss8"};

/// Beyond this order a method buys nothing before float is exhausted.
constexpr std::uint32_t highest_float_order = 4;

/// Higher orders take longer steps.
double coarsest_step(const Plan& plan, const IntegratorInfo& info) {
    const double doublings = info.order >= 8 ? 2 : info.order >= 4 ? 1 : 0;
    return plan.job.step * std::exp2(doublings);
}

void shape(const Plan& plan, Ladder& ladder) {
    const IntegratorInfo& info = info_of(plan, ladder.variant);
    const bool coarse = ladder.variant.kernel->precision == Precision::float32;
    if (info.adaptive) {
        ladder.variant.step = coarse ? 1e-2 : 1e-3;
        ladder.factor = coarse ? 0.1 : 0.01;
        ladder.most_points = coarse ? 5 : 6;
    } else {
        ladder.variant.step = coarsest_step(plan, info);
    }
    if (plan.straight) ladder.least_points = ladder.most_points = 1;
}

struct Way {
    Strategy strategy;
    Precision precision;
};

bool worth_it(const IntegratorInfo& info, const Way& way, const LadderChoice& choice, bool own) {
    if (way.precision == Precision::float32 && info.order > highest_float_order && !info.adaptive && !own) return false;
    if (way.precision == Precision::float32 && choice.quick && !own) return false;
    return way.strategy == Strategy::packet || own || choice.full;
}

}  // namespace

std::vector<Ladder> choose_ladders(const Plan& plan, const LadderChoice& choice, std::vector<std::string>& refused) {
    const std::string& own = plan.scene.integrator.method;
    const auto wanted = [&](const std::string& name) {
        if (plan.straight) return name == own;
        return !choice.quick || name == own || std::count(std::begin(quick_methods), std::end(quick_methods), name) > 0;
    };
    std::vector<Ladder> ladders;
    for (const Way& way : {Way{Strategy::packet, Precision::float64}, Way{Strategy::packet, Precision::float32},
                           Way{Strategy::scalar, Precision::float64}, Way{Strategy::scalar, Precision::float32}})
        for (std::uint32_t i = 0; i < plan.module->integrator_count; ++i) {
            const IntegratorInfo& info = plan.module->integrators[i];
            if (!wanted(info.name) || !worth_it(info, way, choice, info.name == own)) continue;
            const auto variant = find_variant(plan, info.name, way.strategy, way.precision, 0);
            if (!variant) {
                if (std::count(refused.begin(), refused.end(), info.name) == 0) refused.push_back(info.name);
                continue;
            }
            Ladder& ladder = ladders.emplace_back();
            ladder.variant = *variant, ladder.own = info.name == own;
            shape(plan, ladder);
        }
    return ladders;
}

Slope slope_of(const std::vector<double>& steps, const std::vector<double>& errors, double scene_size) {
    Slope slope;
    if (errors.empty()) return slope;
    slope.floor = *std::min_element(errors.begin(), errors.end());
    // Rounding begins to show a little above the floor; errors near the size of the scene follow no power. Of what lies between, the
    // finest steps are the nearest to the limit that defines an order.
    const double rounding = 1e-13 * scene_size;
    const double greatest = 0.03 * scene_size;
    constexpr std::size_t most = 3;
    std::vector<std::array<double, 2>> fitted;
    for (std::size_t i = errors.size(); i-- > 0 && fitted.size() < most;)
        if (errors[i] > 30 * rounding && errors[i] < greatest && (errors[i] >= 2 * slope.floor || slope.floor > 1e3 * rounding))
            fitted.push_back({std::log(steps[i]), std::log(errors[i])});
    if (fitted.size() < 2) return slope;
    double x = 0, y = 0, xx = 0, xy = 0;
    const double n = double(fitted.size());
    for (const auto& [a, b] : fitted) x += a, y += b, xx += a * a, xy += a * b;
    slope.order = (n * xy - x * y) / (n * xx - x * x);
    return slope;
}

}  // namespace kagero

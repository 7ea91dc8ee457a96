/// The part of a step in which a method evaluates derivatives. It matters where derivatives jump
/// (kernels/events/kinks.h).
#pragma once

#include "kernels/methods/methods.h"

#include <algorithm>

namespace kagero {

/// The stages of a step of length h lie between −behind·h before its start and ahead·h after its end.
struct StageReach {
    double behind = 0, ahead = 0;
    /// A stage at the end of the step only approximates the end, so that it may lie on the other side of a kink there.
    bool predicts_end = false;
};

/// Returns the reach of the substeps of a composition or splitting. `stride` is 1 if every fraction moves the position,
/// and 2 if every second one does; `first` is the index of the first that does.
constexpr StageReach reach_of_fractions(Fractions fractions, std::size_t first, std::size_t stride) {
    constexpr double rounding = 1e-12;
    double at = 0, least = 0, greatest = 1;
    for (std::size_t i = first; i < fractions.size(); i += stride) {
        at += fractions[i];
        least = std::min(least, at);
        greatest = std::max(greatest, at);
    }
    return {-least > rounding ? -least : 0, greatest - 1 > rounding ? greatest - 1 : 0, false};
}

/// Returns the reach of an explicit Runge–Kutta method. The nodes are the sums of the rows of its table.
constexpr StageReach reach_of_table(const ButcherTable& table) {
    double least = 0, greatest = 0;
    for (int i = 0; i < table.stages; ++i) {
        double node = 0;
        for (int j = 0; j < i; ++j) node += table.a[i][j];
        least = std::min(least, node);
        greatest = std::max(greatest, node);
    }
    constexpr double close_to_end = 0.95;
    return {-least, std::max(greatest - 1, 0.0), greatest > close_to_end};
}

/// Returns the reach of a method. The nodes of collocation methods lie within the step.
constexpr StageReach stage_reach_of(const Method& method) {
    const Coefficients& c = method.coefficients;
    if (c.table) return reach_of_table(*c.table);
    const bool moves_at_every_fraction = method.kind == StepperKind::composition || method.kind == StepperKind::recipe;
    if (moves_at_every_fraction) return reach_of_fractions(c.fractions, 0, 1);
    return reach_of_fractions(c.fractions, c.kick_first ? 1 : 0, 2);
}

}  // namespace kagero

/// What steps cost, in floating-point operations and in roundings: each kind of step tells it of itself.
#pragma once

#include "kernels/abi.h"
#include "kernels/autodiff/operations.h"
#include "kernels/equations/state.h"
#include "kernels/integrators/coefficients.h"

namespace kagero {

/// How often a method rounds in a step.
struct RoundingCounts {
    double state;   ///< the state
    double sums;    ///< the sum of derivatives that moves it
    double weight;  ///< Σ|b|: what share of the step such sums may be
};

/// Σ|fraction|.
constexpr double weight_of(const Fractions& fractions) {
    double weight = 0;
    for (const double f : fractions) weight += f < 0 ? -f : f;
    return weight;
}

/// The same per step, whether or not rays meet anything.
inline Operations operations_in_space(double per_gradient, double per_step) {
    return {per_gradient, per_step, per_step};
}

/// Steps move q and p in turn, each by its own side of the gradient, with a product and a sum per component.
inline Operations operations_in_turn(const ProgramOperations& program) {
    return operations_in_space(0.5 * (program.force + program.velocity) + 2 * space_size, program.event_functions);
}

}  // namespace kagero

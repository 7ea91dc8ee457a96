/// Functions with which the steppers compute the costs of their steps: floating-point operations and rounding errors.
#pragma once

#include "kernels/abi.h"
#include "kernels/autodiff/operations.h"
#include "kernels/equations/state.h"
#include "kernels/integrators/coefficients.h"

namespace kagero {

/// Numbers of rounding errors that a method makes in one step.
struct RoundingCounts {
    double state;   ///< roundings of the state
    double sums;    ///< roundings of the weighted sum of derivatives that is added to the state
    double weight;  ///< Σ|b| over the weights b of that sum
};

/// Returns the sum of the absolute values of the fractions.
constexpr double weight_of(const Fractions& fractions) {
    double weight = 0;
    for (const double f : fractions) weight += f < 0 ? -f : f;
    return weight;
}

/// Returns the operations of a stepper whose cost per step does not depend on whether the scene has surfaces.
inline Operations make_operations(double per_gradient, double per_step) {
    return {per_gradient, per_step, per_step};
}

/// Returns the operations of a stepper that updates q and p alternately. Each update needs ∂K/∂q or ∂K/∂p, which is
/// half of a gradient, and a product and a sum per component.
inline Operations alternating_operations(const ProgramOperations& program) {
    return make_operations(0.5 * (program.force + program.velocity) + 2 * space_size, program.event_functions);
}

}  // namespace kagero

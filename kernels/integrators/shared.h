/// Declarations of code that all Hamiltonians share. The code is compiled once per value type, in the translation units
/// that include shared_steps.h.
#pragma once

#include "kernels/equations/called_system.h"
#include "kernels/integrators/curve.h"
#include "kernels/integrators/stepper_state.h"

namespace kagero {

/// The implicit half steps of Satoh (2003), eq. (9), and of its adjoint.
enum class HalfStep {
    kick,   ///< p' = p − τ ∂K/∂q(q, p')
    drift,  ///< q' = q + τ ∂K/∂p(q', p)
};

/// Newton solvers for called systems, and dense output, which needs no system. N is the number of carried quantities.
template <class V, int N = default_carried>
struct SharedSolvers {
    using S = ScalarOf<V>;

    /// Solves one implicit half step by Newton's method from the initial guess x (newton.h).
    static Vec3<V> newton(HalfStep half, const CalledSystem<V, N>& system, StepperState<V, N>& step, const Vec3<V>& q,
                          const Vec3<V>& p, const V& tau, Vec3<V> x);
    /// Solves the s stages of a Gauss step by Newton's method (newton_stages.h). Component k of ∂K/∂(q, p) at stage i
    /// is stages[i · per_stage + k · per_component].
    static void newton_stages(const CalledSystem<V, N>& system, StepperState<V, N>& step, const GaussNumbers<S>& w,
                              int s, V* stages, int per_stage, int per_component);
    /// Returns the dense output of a Gauss step: its collocation polynomial.
    static Curve<V> collocation_curve(const StepperState<V, N>& step, const Coefficients& coefficients);
};

/// A stepper that is compiled once for all called systems. It exists for steppers whose `shareable` returns true.
template <class Stepper, class V, int N = default_carried>
struct SharedStepper {
    static void begin(const CalledSystem<V, N>& system, StepperState<V, N>& step, const Coefficients& coefficients);
    static void step(const CalledSystem<V, N>& system, StepperState<V, N>& step, const Coefficients& coefficients);
};

}  // namespace kagero

/// What all Hamiltonians share: compiled once per value type, where shared_steps.h is included.
#pragma once

#include "kernels/equations/called_system.h"
#include "kernels/integrators/curve.h"
#include "kernels/integrators/stepper_state.h"

namespace kagero {

/// Which half of eq. (9) is implicit.
enum class Side { kick, drift };  // p' = p − τ ∂K/∂q(q, p')  ·  q' = q + τ ∂K/∂p(q', p)

/// What few rays need, in any called system, and dense output, which needs none. Rays carry N quantities along.
template <class V, int N = default_carried>
struct Shared {
    using S = ScalarOf<V>;

    /// Newton's method for half a step (newton.h).
    static Vec3<V> newton(Side side, const CalledSystem<V, N>& system, StepperState<V, N>& f, const Vec3<V>& q,
                          const Vec3<V>& p, const V& tau, Vec3<V> x);
    /// … and for the stages of a Gauss step (newton_stages.h); component k of stage i is stages[i · per_stage + k ·
    /// per_component].
    static void newton_stages(const CalledSystem<V, N>& system, StepperState<V, N>& f, const GaussNumbers<S>& w, int s,
                              V* stages, int per_stage, int per_component);
    /// Dense output of a Gauss step.
    static Curve<V> collocation_curve(const StepperState<V, N>& f, const Coefficients& coefficients);
};

/// A kind of step in any called system, for kinds that are `shareable`.
template <class Stepper, class V, int N = default_carried>
struct SharedStepper {
    static void begin(const CalledSystem<V, N>& system, StepperState<V, N>& f, const Coefficients& coefficients);
    static void step(const CalledSystem<V, N>& system, StepperState<V, N>& f, const Coefficients& coefficients);
};

}  // namespace kagero

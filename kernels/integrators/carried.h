/// Integrates the carried quantities of a ray: λ, and further quantities whose rates are defined by the system
/// (`carried_in`). Each quantity is the integral of its rate over τ, computed with the nodes and weights of the method
/// that advances the state. The error of the integral therefore has the order of that method. The rate of λ is dλ/dτ.
/// Without time rescaling, λ increases by h in a step.
#pragma once

#include "kernels/integrators/stepper_state.h"

namespace kagero {

/// Returns true if a step has to integrate rates.
template <class System, class V, int N>
KAGERO_INLINE bool integrates_carried(const System& system, const StepperState<V, N>& step) {
    static_assert(carried_in<System>() == N, "StepperState and System must have the same number of carried quantities");
    return (N > 1 || system.rescaled) && step.options.compute_carried;
}

/// Adds `increment` to carried quantity k of the start of the step, and stores the sum at the end. The rounding error
/// of the sum is kept and added in the next step (compensated summation, Kahan 1965).
template <class V, int N>
KAGERO_INLINE void advance_carried(StepperState<V, N>& step, int k, const V& increment) {
    const V start = step.start.carried(k), corrected = increment + step.start.carried_rounding[k],
            sum = start + corrected;
    step.end.carried(k) = sum;
    step.end.carried_rounding[k] = corrected - (sum - start);
}

/// Advances λ by h for a step that integrates no rates. Further carried quantities keep their values.
template <class V, int N>
KAGERO_INLINE void advance_parameter_only(StepperState<V, N>& step) {
    advance_carried(step, 0, step.h);
    for (int k = 1; k < N; ++k) advance_carried(step, k, V(ScalarOf<V>(0)));
}

/// Weighted sums of the rates over the nodes of one step, one sum per carried quantity.
template <class V, int N>
class CarriedSums {
    using S = ScalarOf<V>;

public:
    KAGERO_INLINE CarriedSums() {
        for (V& sum : sum_) sum = V(S(0));
    }

    /// Adds the rates at one node of the method with the given weight: the length of the substep, for a method that
    /// consists of substeps, or the coefficient b of the stage.
    template <class System>
    KAGERO_INLINE void add(const System& system, const V& weight, const State<V>& node) {
        V rates[N];
        rates_at(system, node, rates);
        for (int k = 0; k < N; ++k) sum_[k] = fma(weight, rates[k], sum_[k]);
    }
    /// Adds the rates at all stages of one ray. Lane i of `nodes` contains stage i.
    template <class System, class L>
    KAGERO_INLINE void add_lanes(const System& system, const V* weights, int stages, const State<L>& nodes) {
        L rates[N];
        rates_at(system, nodes, rates);
        for (int k = 0; k < N; ++k)
            for (int i = 0; i < stages; ++i) sum_[k] = fma(weights[i], get_lane(rates[k], i), sum_[k]);
    }

    /// Writes the carried quantities at the end of a step that consists of substeps.
    template <class System>
    KAGERO_INLINE void finish_substeps(const System& system, StepperState<V, N>& step) const {
        finish(system, step, V(S(1)));
    }
    /// Writes the carried quantities at the end of a step that has stages.
    template <class System>
    KAGERO_INLINE void finish_stages(const System& system, StepperState<V, N>& step) const {
        finish(system, step, step.h);
    }

private:
    /// Advances the carried quantities by the sums times `factor`. Without time rescaling, λ advances by h.
    template <class System>
    KAGERO_INLINE void finish(const System& system, StepperState<V, N>& step, const V& factor) const {
        advance_carried(step, 0, system.rescaled ? factor * sum_[0] : step.h);
        for (int k = 1; k < N; ++k) advance_carried(step, k, factor * sum_[k]);
    }
    template <class System, class L>
    KAGERO_INLINE static void rates_at(const System& system, const State<L>& node, L (&rates)[N]) {
        rates[0] = system.time_rescaling_factor(node);
        if constexpr (N > 1) system.carried_rates(node, rates + 1);
    }

    V sum_[N];
};

}  // namespace kagero

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

/// Advances λ by h for a step that integrates no rates. Further carried quantities keep their values.
template <class V, int N>
KAGERO_INLINE void advance_parameter_only(StepperState<V, N>& step) {
    step.end.parameter = step.start.parameter + step.h;
    for (int k = 1; k < N; ++k) step.end.carried(k) = step.start.carried(k);
}

/// Weighted sums of the rates over the nodes of one step, one sum per carried quantity.
template <class V, int N>
class CarriedSums {
    using S = ScalarOf<V>;

public:
    /// Returns sums for a method that consists of substeps. The weight of a node is the length of its substep. The
    /// initial values of the sums are the quantities at the start of the step.
    KAGERO_INLINE static CarriedSums for_substeps(const StepperState<V, N>& step) {
        CarriedSums sums;
        for (int k = 0; k < N; ++k) sums.sum_[k] = step.start.carried(k);
        return sums;
    }
    /// Returns sums for a method that has stages. The weight of a node is the coefficient b of its stage. The initial
    /// values of the sums are 0.
    KAGERO_INLINE static CarriedSums for_stages() {
        CarriedSums sums;
        for (V& sum : sums.sum_) sum = V(S(0));
        return sums;
    }

    /// Adds the rates at one node of the method with the given weight.
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

    /// Writes the carried quantities at the end of the step, for sums that were created by `for_substeps`.
    template <class System>
    KAGERO_INLINE void finish_substeps(const System& system, StepperState<V, N>& step) const {
        step.end.parameter = system.rescaled ? sum_[0] : step.start.parameter + step.h;
        for (int k = 1; k < N; ++k) step.end.carried(k) = sum_[k];
    }
    /// Writes the carried quantities at the end of the step, for sums that were created by `for_stages`.
    template <class System>
    KAGERO_INLINE void finish_stages(const System& system, StepperState<V, N>& step) const {
        step.end.parameter =
            system.rescaled ? fma(step.h, sum_[0], step.start.parameter) : step.start.parameter + step.h;
        for (int k = 1; k < N; ++k) step.end.carried(k) = fma(step.h, sum_[k], step.start.carried(k));
    }

private:
    template <class System, class L>
    KAGERO_INLINE static void rates_at(const System& system, const State<L>& node, L (&rates)[N]) {
        rates[0] = system.time_rescaling_factor(node);
        if constexpr (N > 1) system.carried_rates(node, rates + 1);
    }

    V sum_[N];
};

}  // namespace kagero

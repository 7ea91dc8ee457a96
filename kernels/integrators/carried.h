/// Integrates what a ray carries along beside its state: λ, and the further quantities whose rates a system states
/// (`carried_in`). Each is the integral of its rate over τ, by the nodes and weights of the method that moves the
/// state. Hence it has the order of the method. The rate of λ is dλ/dτ; where a system is not rescaled, λ is exactly
/// start + h.
#pragma once

#include "kernels/integrators/stepper_state.h"

namespace kagero {

/// Whether a step integrates rates at all.
template <class System, class V, int N>
KAGERO_INLINE bool integrates_carried(const System& system, const StepperState<V, N>& f) {
    static_assert(carried_in<System>() == N, "the packet carries another number of quantities than its system states");
    return (N > 1 || system.rescaled) && f.options.want_carried;
}

/// Advances λ by a step that integrates no rates; further quantities keep their values.
template <class V, int N>
KAGERO_INLINE void carry_evenly(StepperState<V, N>& f) {
    f.end.parameter = f.start.parameter + f.h;
    for (int k = 1; k < N; ++k) f.end.carried(k) = f.start.carried(k);
}

/// The sums of a step, one per quantity.
template <class V, int N>
class CarriedSums {
    using S = ScalarOf<V>;

public:
    /// For methods of substeps: a node counts by the length of its substep, and the sums are the quantities themselves.
    KAGERO_INLINE static CarriedSums of_lengths(const StepperState<V, N>& f) {
        CarriedSums sums;
        for (int k = 0; k < N; ++k) sums.sum_[k] = f.start.carried(k);
        return sums;
    }
    /// For methods of stages: a node counts by its weight in the step.
    KAGERO_INLINE static CarriedSums of_weights() {
        CarriedSums sums;
        for (V& sum : sums.sum_) sum = V(S(0));
        return sums;
    }

    /// One node of the method; `share` is its weight, or the length of its substep.
    template <class System>
    KAGERO_INLINE void add(const System& system, const V& share, const State<V>& node) {
        V rates[N];
        rates_at(system, node, rates);
        for (int k = 0; k < N; ++k) sum_[k] = fma(share, rates[k], sum_[k]);
    }
    /// All stages of one ray, which lie in the lanes of `nodes`.
    template <class System, class L>
    KAGERO_INLINE void add_lanes(const System& system, const V* weights, int stages, const State<L>& nodes) {
        L rates[N];
        rates_at(system, nodes, rates);
        for (int k = 0; k < N; ++k)
            for (int i = 0; i < stages; ++i) sum_[k] = fma(weights[i], get_lane(rates[k], i), sum_[k]);
    }

    /// Writes the quantities at the end of the step.
    template <class System>
    KAGERO_INLINE void finish_lengths(const System& system, StepperState<V, N>& f) const {
        f.end.parameter = system.rescaled ? sum_[0] : f.start.parameter + f.h;
        for (int k = 1; k < N; ++k) f.end.carried(k) = sum_[k];
    }
    template <class System>
    KAGERO_INLINE void finish_weights(const System& system, StepperState<V, N>& f) const {
        f.end.parameter = system.rescaled ? fma(f.h, sum_[0], f.start.parameter) : f.start.parameter + f.h;
        for (int k = 1; k < N; ++k) f.end.carried(k) = fma(f.h, sum_[k], f.start.carried(k));
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

/// Methods that split H into two parts whose flows are known exactly and apply these flows alternately. They are
/// explicit and symplectic; the fractions determine their order.
#pragma once

#include "kernels/integrators/composition.h"

namespace kagero {

/// Stepper for K = ½|p|² + V(q), with or without time rescaling. A substep of length t is a drift q += t p or a kick
/// p −= t ∂V/∂q. The fractions are those of the Runge–Kutta–Nyström methods of Blanes & Moan (2002).
struct Nystroem {
    static constexpr MethodFamily family = MethodFamily::nystroem;
    template <class System>
    static constexpr const char* refusal() {
        if (rates_need_p<System>())
            return "the method can carry only quantities whose rates depend on the position alone, and a rate of this "
                   "system depends on the momentum";
        return System::separable ? nullptr : "the integrated Hamiltonian is not of the form |p|^2/2 + V(q)";
    }
    static Operations operations(const Coefficients&, const ProgramOperations& program) {
        return alternating_operations(program);
    }
    static constexpr RoundingCounts rounding_counts(const Coefficients& c) {
        return {0.5 * double(c.fractions.size()), 1, 0.5 * weight_of(c.fractions)};
    }
    static constexpr bool steps_without_begin = true;
    template <class System, class V, int N>
    static void begin(const System&, StepperState<V, N>&, const Coefficients&) {}

    template <class System, class V, int N>
    static void step(const System& system, StepperState<V, N>& step, const Coefficients& coefficients) {
        // With N > 1, rates of carried quantities may depend on coordinates that are cyclic in K.
        if constexpr (System::cyclic.any() && N == 1)
            if (step.options.use_symmetry) return step_with_cyclic<System::cyclic>(system, step, coefficients);
        step_with_cyclic<Axes{}>(system, step, coefficients);
    }

private:
    template <class System>
    static constexpr bool rates_need_p() {
        if constexpr (carried_in<System>() > 1) return System::carried_rates_need_p;
        else return false;
    }
    /// Performs a step. The momenta of the coordinates in `cyclic` are constant, so these coordinates change linearly
    /// and are updated once, at the end of the step.
    template <Axes cyclic, class System, class V, int N>
    KAGERO_INLINE static void step_with_cyclic(const System& system, StepperState<V, N>& step,
                                               const Coefficients& coefficients) {
        using S = ScalarOf<V>;
        Vec3<V> q = step.start.q(), p = step.start.p();
        CarriedSums<V, N> carried;
        bool kick = coefficients.kick_first;
        for (const double fraction : coefficients.fractions) {
            const V t = step.h * V(S(fraction));
            if (kick) {
                const State<V> state = make_state(step, q, p);
                const Vec3<V> force = system.gradient_q(state);
                if constexpr (!cyclic.x) p.x = fnma(t, force.x, p.x);
                if constexpr (!cyclic.y) p.y = fnma(t, force.y, p.y);
                if constexpr (!cyclic.z) p.z = fnma(t, force.z, p.z);
                if (integrates_carried(system, step)) carried.add(system, t, state);
                step.gradients += V(S(1));
            } else {
                if constexpr (!cyclic.x) q.x = fma(t, p.x, q.x);
                if constexpr (!cyclic.y) q.y = fma(t, p.y, q.y);
                if constexpr (!cyclic.z) q.z = fma(t, p.z, q.z);
            }
            kick = !kick;
        }
        if constexpr (cyclic.x) q.x = fma(step.h, p.x, q.x);
        if constexpr (cyclic.y) q.y = fma(step.h, p.y, q.y);
        if constexpr (cyclic.z) q.z = fma(step.h, p.z, q.z);
        step.end.set(q, p);
        carried.finish_substeps(system, step);
        step.solved = all_lanes<V>();
    }
};

/// Stepper for H = ½(|p|² − p_t²) + R, where the flow of the remainder R is known in closed form, as for Kerr–Schild
/// metrics. The first substep is a drift.
struct ExactSplit {
    static constexpr MethodFamily family = MethodFamily::exact_split;
    template <class System>
    static constexpr const char* refusal() {
        if (System::rescaled)
            return "the exact splitting integrates H without time rescaling; set integrator.rescale = \"none\"";
        if (refusal_to_carry<System>()) return refusal_to_carry<System>();
        return ExactlySplit<typename System::Hamiltonian>
                   ? nullptr
                   : "the Hamiltonian of this space has no exact Kerr-Schild splitting";
    }
    static Operations operations(const Coefficients&, const ProgramOperations& program) {
        return alternating_operations(program);
    }
    /// Each substep is counted as two roundings of the state, because the flow of R changes both q and p.
    static constexpr RoundingCounts rounding_counts(const Coefficients& c) {
        return {2.0 * double(c.fractions.size()), 1, 0.5 * weight_of(c.fractions)};
    }
    static constexpr bool steps_without_begin = true;
    template <class System, class V, int N>
    static void begin(const System&, StepperState<V, N>&, const Coefficients&) {}

    template <class System, class V, int N>
    static void step(const System& system, StepperState<V, N>& step, const Coefficients& coefficients) {
        using S = ScalarOf<V>;
        const auto k = system.template parameters<V>();
        Vec3<V> q = step.start.q(), p = step.start.p();
        bool drift = true;
        for (const double fraction : coefficients.fractions) {
            const V t = step.h * V(S(fraction));
            if (drift) {
                q = advance(q, t, p);
            } else {
                System::Hamiltonian::remainder_flow(k, q, p, step.start.pt(), t);
                step.gradients += V(S(1));
            }
            drift = !drift;
        }
        step.end.set(q, p);
        advance_parameter_only(step);
        step.solved = all_lanes<V>();
    }
};

}  // namespace kagero

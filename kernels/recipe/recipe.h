/// The recipe as printed: the method of Satoh (2003), eqs. (9)–(15), without changes, for comparison. H is the sum of
/// two parts, H_A and H_B. S_A and S_B integrate H_A and H_B by the semi-implicit Euler method, eq. (9). S2(τ) is
/// S_A(τ/2) S_B(τ) S_A(τ/2), and S4 is a composition of S2. Newton's method solves the implicit equations.
///
/// S2 would have order 2 if S_A and S_B were exact or self-adjoint. Eq. (9) is neither, so that S2 and S4 have order 1.
/// The methods in integrators/composition.h have the orders that the paper states.
#pragma once

#include "kernels/integrators/composition.h"

namespace kagero {

/// Stepper of the recipe as printed.
struct Recipe {
    static constexpr MethodFamily family = MethodFamily::recipe;
    template <class System>
    static constexpr const char* refusal() {
        if (System::rescaled)
            return "the recipe as printed integrates H without time rescaling; set integrator.rescale = \"none\"";
        if (refusal_to_carry<System>()) return refusal_to_carry<System>();
        return Parted<typename System::Hamiltonian> ? nullptr
                                                    : "the Hamiltonian of this space declares no parts H_A and H_B";
    }
    static Operations operations(const Coefficients&, const ProgramOperations& program) {
        return alternating_operations(program);
    }
    static constexpr RoundingCounts rounding_counts(const Coefficients& c) {
        return {3.0 * double(c.fractions.size()), 1, weight_of(c.fractions)};
    }
    static constexpr bool steps_without_begin = true;  // `begin` does nothing
    template <class System, class V>
    static void begin(const System&, StepperState<V>&, const Coefficients&) {}

    /// Performs a step: S2 with the step size h·fraction, for each fraction of the method.
    template <class System, class V>
    static void step(const System& system, StepperState<V>& step, const Coefficients& coefficients) {
        using S = ScalarOf<V>;
        Vec3<V> q = step.start.q(), p = step.start.p();
        step.solved = all_lanes<V>();
        for (const double fraction : coefficients.fractions) {
            euler(system.part_a(), step, q, p, step.h * V(S(fraction / 2)));
            euler(system.part_b(), step, q, p, step.h * V(S(fraction)));
            euler(system.part_a(), step, q, p, step.h * V(S(fraction / 2)));
        }
        step.end.set(q, p);
        advance_parameter_only(step);
    }

private:
    /// Advances q and p by one step of length `tau` of the semi-implicit Euler method, eq. (9), for one part of H.
    template <class Part, class V>
    KAGERO_INLINE static void euler(const Part& part, StepperState<V>& step, Vec3<V>& q, Vec3<V>& p, const V& tau) {
        const Vec3<V> force = part.gradient_q(make_state(step, q, p));
        step.gradients += V(ScalarOf<V>(2));
        if constexpr (Part::force_needs_p)
            p = SharedSolvers<V>::newton(HalfStep::kick, as_called<V>(part), step, q, p, tau, retreat(p, tau, force));
        else p = retreat(p, tau, force);
        q = advance(q, tau, part.gradient_p(make_state(step, q, p)));
    }
};

}  // namespace kagero

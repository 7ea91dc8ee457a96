/// The recipe of Satoh (2003), eqs. (9)–(15), as printed, for comparison. H has two parts, H_A and H_B. S_A and S_B
/// integrate one part by the semi-implicit Euler method, eq. (9). S2(τ) = S_A(τ/2) S_B(τ) S_A(τ/2), and S4 is composed
/// of S2. Newton's method solves the implicit equations.
///
/// S2 would have order 2 if S_A and S_B were exact or self-adjoint. Eq. (9) is neither, so all methods built on it have
/// order 1. The methods in integrators/composition.h have the intended order.
#pragma once

#include "kernels/integrators/composition.h"

namespace kagero {

/// Stepper for the printed recipe.
struct Recipe {
    static constexpr MethodFamily family = MethodFamily::recipe;
    template <class System>
    static constexpr const char* refusal() {
        if (System::rescaled)
            return "the printed recipe integrates H without time rescaling; set integrator.rescale = \"none\"";
        if (refusal_to_carry<System>()) return refusal_to_carry<System>();
        return Parted<typename System::Hamiltonian> ? nullptr
                                                    : "the Hamiltonian of this space declares no parts H_A and H_B";
    }
    static Operations operations(const Coefficients&, const ProgramOperations& program) {
        return alternating_operations(program);
    }
    static constexpr RoundingCounts roundings(const Coefficients& c) {
        return {3.0 * double(c.fractions.size()), 1, weight_of(c.fractions)};
    }
    static constexpr bool resumes = true;
    template <class System, class V>
    static void begin(const System&, StepperState<V>&, const Coefficients&) {}

    /// Performs a step: S2 for each fraction of the step.
    template <class System, class V>
    static void step(const System& system, StepperState<V>& f, const Coefficients& coefficients) {
        using S = ScalarOf<V>;
        Vec3<V> q = f.start.q(), p = f.start.p();
        f.solved = all_lanes<V>();
        for (const double weight : coefficients.fractions) {
            euler(system.part_a(), f, q, p, f.h * V(S(weight / 2)));
            euler(system.part_b(), f, q, p, f.h * V(S(weight)));
            euler(system.part_a(), f, q, p, f.h * V(S(weight / 2)));
        }
        f.end.set(q, p);
        advance_parameter_only(f);
    }

private:
    /// Advances q and p by the semi-implicit Euler method, eq. (9), for one part of H.
    template <class Part, class V>
    KAGERO_INLINE static void euler(const Part& part, StepperState<V>& f, Vec3<V>& q, Vec3<V>& p, const V& tau) {
        const Vec3<V> force = part.dq(make_state(f, q, p));
        f.gradients += V(ScalarOf<V>(2));
        if constexpr (Part::force_needs_p)
            p = SharedSolvers<V>::newton(HalfStep::kick, as_called<V>(part), f, q, p, tau, retreat(p, tau, force));
        else p = retreat(p, tau, force);
        q = advance(q, tau, part.dp(make_state(f, q, p)));
    }
};

}  // namespace kagero

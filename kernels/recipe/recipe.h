/// The printed recipe of Satoh (2003), eqs. (9)–(15), as a labelled baseline: semi-implicit Euler for each of two parts
/// of H, S2(τ) = S_A(τ/2) S_B(τ) S_A(τ/2), and S4 made of S2, all solved by Newton's method.
///
/// S2 would be of order 2 if S_A and S_B were exact or self-adjoint; eq. (9) is neither, so everything built on it
/// stays at order 1. `composition.h` is the cure.
#pragma once

#include "kernels/integrators/composition.h"

namespace kagero {

struct Recipe {
    static constexpr Family family = Family::recipe;
    template <class System>
    static constexpr const char* refusal() {
        if (System::rescaled) return "the printed recipe integrates H itself, not a rescaled one";
        if (refusal_to_carry<System>()) return refusal_to_carry<System>();
        return Parted<typename System::Hamiltonian> ? nullptr : "its Hamiltonian declares no parts H_A and H_B";
    }
    static Operations operations(const Coefficients&, const ProgramOperations& program) {
        return operations_in_turn(program);
    }
    static constexpr RoundingCounts roundings(const Coefficients& c) {
        return {3.0 * double(c.fractions.size()), 1, weight_of(c.fractions)};
    }
    static constexpr bool resumes = true;
    template <class System, class V>
    static void begin(const System&, StepperState<V>&, const Coefficients&) {}

    /// The fractions are weights of S2.
    template <class System, class V>
    static void step(const System& system, StepperState<V>& f, const Coefficients& coefficients) {
        using S = ScalarOf<V>;
        Vec3<V> q = f.start.q(), p = f.start.p();
        f.solved = always<V>();
        for (const double weight : coefficients.fractions) {
            euler(system.part_a(), f, q, p, f.h * V(S(weight / 2)));
            euler(system.part_b(), f, q, p, f.h * V(S(weight)));
            euler(system.part_a(), f, q, p, f.h * V(S(weight / 2)));
        }
        f.end.set(q, p);
        carry_evenly(f);
    }

private:
    /// Eq. (9).
    template <class Part, class V>
    KAGERO_INLINE static void euler(const Part& part, StepperState<V>& f, Vec3<V>& q, Vec3<V>& p, const V& tau) {
        const Vec3<V> force = part.dq(joined(f, q, p));
        f.gradients += V(ScalarOf<V>(2));
        if constexpr (Part::force_needs_p)
            p = Shared<V>::newton(Side::kick, as_called<V>(part), f, q, p, tau, retreat(p, tau, force));
        else p = retreat(p, tau, force);
        q = advance(q, tau, part.dp(joined(f, q, p)));
    }
};

}  // namespace kagero

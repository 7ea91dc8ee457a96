/// Splitting H into two parts whose flows are known exactly, taken in turn: explicit and symplectic, of any order the
/// fractions give.
#pragma once

#include "kernels/integrators/composition.h"

namespace kagero {

/// K = ½|p|² + V(q), as it is or after rescaling: drift q += t p, kick p −= t ∂V/∂q. With the Runge–Kutta–Nyström
/// fractions of Blanes & Moan (2002).
struct Nystroem {
    static constexpr Family family = Family::nystroem;
    template <class System>
    static constexpr const char* refusal() {
        if (rates_need_p<System>())
            return "it integrates carried quantities by position alone, and here a rate depends on p";
        return System::separable ? nullptr : "its Hamiltonian is not of the form |p|^2/2 + V(q)";
    }
    static Operations operations(const Coefficients&, const ProgramOperations& program) {
        return operations_in_turn(program);
    }
    static constexpr RoundingCounts roundings(const Coefficients& c) {
        return {0.5 * double(c.fractions.size()), 1, 0.5 * weight_of(c.fractions)};
    }
    static constexpr bool resumes = true;
    template <class System, class V, int N>
    static void begin(const System&, StepperState<V, N>&, const Coefficients&) {}

    template <class System, class V, int N>
    static void step(const System& system, StepperState<V, N>& f, const Coefficients& coefficients) {
        // Rates of further quantities may depend on the coordinates that K does not depend on.
        if constexpr (System::cyclic.any() && N == 1)
            if (f.options.use_symmetry) return step_along<System::cyclic>(system, f, coefficients);
        step_along<Axes{}>(system, f, coefficients);
    }

private:
    template <class System>
    static constexpr bool rates_need_p() {
        if constexpr (carried_in<System>() > 1) return System::carried_rates_need_p;
        else return false;
    }
    /// Along cyclic coordinates, whose momenta stay, rays move evenly: they are left to the end.
    template <Axes cyclic, class System, class V, int N>
    KAGERO_INLINE static void step_along(const System& system, StepperState<V, N>& f,
                                         const Coefficients& coefficients) {
        using S = ScalarOf<V>;
        Vec3<V> q = f.start.q(), p = f.start.p();
        auto carried = CarriedSums<V, N>::of_lengths(f);
        bool kick = coefficients.kick_first;
        for (const double fraction : coefficients.fractions) {
            const V t = f.h * V(S(fraction));
            if (kick) {
                const State<V> here = joined(f, q, p);
                const Vec3<V> force = system.dq(here);
                if constexpr (!cyclic.x) p.x = fnma(t, force.x, p.x);
                if constexpr (!cyclic.y) p.y = fnma(t, force.y, p.y);
                if constexpr (!cyclic.z) p.z = fnma(t, force.z, p.z);
                if (integrates_carried(system, f)) carried.add(system, t, here);
                f.gradients += V(S(1));
            } else {
                if constexpr (!cyclic.x) q.x = fma(t, p.x, q.x);
                if constexpr (!cyclic.y) q.y = fma(t, p.y, q.y);
                if constexpr (!cyclic.z) q.z = fma(t, p.z, q.z);
            }
            kick = !kick;
        }
        if constexpr (cyclic.x) q.x = fma(f.h, p.x, q.x);
        if constexpr (cyclic.y) q.y = fma(f.h, p.y, q.y);
        if constexpr (cyclic.z) q.z = fma(f.h, p.z, q.z);
        f.end.set(q, p);
        carried.finish_lengths(system, f);
        f.solved = always<V>();
    }
};

/// ½(|p|² − p_t²) + K with K's flow in closed form, as Kerr–Schild metrics have it: drift first.
struct ExactSplit {
    static constexpr Family family = Family::exact_split;
    template <class System>
    static constexpr const char* refusal() {
        if (System::rescaled) return "the exact split integrates H itself, not a rescaled one";
        if (refusal_to_carry<System>()) return refusal_to_carry<System>();
        return ExactlySplit<typename System::Hamiltonian> ? nullptr : "its Hamiltonian has no exact Kerr-Schild split";
    }
    static Operations operations(const Coefficients&, const ProgramOperations& program) {
        return operations_in_turn(program);
    }
    /// A kick turns and stretches both q and p.
    static constexpr RoundingCounts roundings(const Coefficients& c) {
        return {2.0 * double(c.fractions.size()), 1, 0.5 * weight_of(c.fractions)};
    }
    static constexpr bool resumes = true;
    template <class System, class V, int N>
    static void begin(const System&, StepperState<V, N>&, const Coefficients&) {}

    template <class System, class V, int N>
    static void step(const System& system, StepperState<V, N>& f, const Coefficients& coefficients) {
        using S = ScalarOf<V>;
        const auto k = system.template parameters<V>();
        Vec3<V> q = f.start.q(), p = f.start.p();
        bool drift = true;
        for (const double fraction : coefficients.fractions) {
            const V t = f.h * V(S(fraction));
            if (drift) {
                q = advance(q, t, p);
            } else {
                System::Hamiltonian::remainder_flow(k, q, p, f.start.pt(), t);
                f.gradients += V(S(1));
            }
            drift = !drift;
        }
        f.end.set(q, p);
        carry_evenly(f);
        f.solved = always<V>();
    }
};

}  // namespace kagero

/// Splitting H into two parts whose flows are known exactly, taken in turn: explicit and symplectic, of any order the fractions give.
#pragma once

#include "kernels/integrators/composition.h"

namespace kagero {

/// K = ½|p|² + V(q), as it is or after rescaling: drift q += t p, kick p −= t ∂V/∂q. With the Runge–Kutta–Nyström fractions of Blanes
/// & Moan (2002).
struct Nystroem {
    static constexpr Family family = Family::nystroem;
    template <class System>
    static constexpr const char* refusal() {
        return System::separable ? nullptr : "its Hamiltonian is not of the form |p|^2/2 + V(q)";
    }
    static Operations operations(const Coefficients&, const ProgramOperations& program) { return operations_in_turn(program); }
    static constexpr RoundingCounts roundings(const Coefficients& c) { return {0.5 * double(c.fractions.size()), 1, 0.5 * weight_of(c.fractions)}; }
    static constexpr bool resumes = true;
    template <class System, class V>
    static void begin(const System&, Flow<V>&, const Coefficients&) {}

    template <class System, class V>
    static void step(const System& system, Flow<V>& f, const Coefficients& coefficients) {
        if constexpr (System::cyclic.any())
            if (f.use_symmetry) return step_along<System::cyclic>(system, f, coefficients);
        step_along<Axes{}>(system, f, coefficients);
    }

private:
    /// Along cyclic coordinates, whose momenta stay, rays move evenly: they are left to the end.
    template <Axes cyclic, class System, class V>
    KAGERO_INLINE static void step_along(const System& system, Flow<V>& f, const Coefficients& coefficients) {
        using S = ScalarOf<V>;
        Vec3<V> q = f.start.q(), p = f.start.p();
        V parameter = f.start.parameter;
        bool kick = coefficients.kick_first;
        for (const double fraction : coefficients.fractions) {
            const V t = f.h * V(S(fraction));
            if (kick) {
                const State<V> here = joined(f, q, p);
                const Vec3<V> force = system.dq(here);
                if constexpr (!cyclic.x) p.x = neg_mul_add(t, force.x, p.x);
                if constexpr (!cyclic.y) p.y = neg_mul_add(t, force.y, p.y);
                if constexpr (!cyclic.z) p.z = neg_mul_add(t, force.z, p.z);
                if (f.want_parameter) parameter = mul_add(t, system.pace(here), parameter);
                f.gradients += V(S(1));
            } else {
                if constexpr (!cyclic.x) q.x = mul_add(t, p.x, q.x);
                if constexpr (!cyclic.y) q.y = mul_add(t, p.y, q.y);
                if constexpr (!cyclic.z) q.z = mul_add(t, p.z, q.z);
            }
            kick = !kick;
        }
        if constexpr (cyclic.x) q.x = mul_add(f.h, p.x, q.x);
        if constexpr (cyclic.y) q.y = mul_add(f.h, p.y, q.y);
        if constexpr (cyclic.z) q.z = mul_add(f.h, p.z, q.z);
        f.end.set(q, p);
        f.end.parameter = system.rescaled ? parameter : f.start.parameter + f.h;
        f.solved = always<V>();
    }
};

/// ½(|p|² − p_t²) + K with K's flow in closed form, as Kerr–Schild metrics have it: drift first.
struct ExactSplit {
    static constexpr Family family = Family::exact_split;
    template <class System>
    static constexpr const char* refusal() {
        if (System::rescaled) return "the exact split integrates H itself, not a rescaled one";
        return ExactlySplit<typename System::Hamiltonian> ? nullptr : "its Hamiltonian has no exact Kerr-Schild split";
    }
    static Operations operations(const Coefficients&, const ProgramOperations& program) { return operations_in_turn(program); }
    /// A kick turns and stretches both q and p.
    static constexpr RoundingCounts roundings(const Coefficients& c) { return {2.0 * double(c.fractions.size()), 1, 0.5 * weight_of(c.fractions)}; }
    static constexpr bool resumes = true;
    template <class System, class V>
    static void begin(const System&, Flow<V>&, const Coefficients&) {}

    template <class System, class V>
    static void step(const System& system, Flow<V>& f, const Coefficients& coefficients) {
        using S = ScalarOf<V>;
        const auto k = system.template parameters<V>();
        Vec3<V> q = f.start.q(), p = f.start.p();
        bool drift = true;
        for (const double fraction : coefficients.fractions) {
            const V t = f.h * V(S(fraction));
            if (drift) {
                q = advance(q, t, p);
            } else {
                System::Hamiltonian::flow_of_rest(k, q, p, f.start.y[6], t);
                f.gradients += V(S(1));
            }
            drift = !drift;
        }
        f.end.set(q, p);
        f.end.parameter = f.start.parameter + f.h;
        f.solved = always<V>();
    }
};

}  // namespace kagero

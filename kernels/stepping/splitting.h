/// Splitting H into two parts whose flows are known exactly, taken in turn: explicit and symplectic, of any order the fractions give.
#pragma once

#include "kernels/stepping/composition.h"

namespace kagero {

/// K = ½|p|² + V(q), as it is or after rescaling: drift q += t p, kick p −= t ∂V/∂q. With the Runge–Kutta–Nyström fractions of Blanes
/// & Moan (2002).
struct Nystroem {
    template <class System>
    static constexpr const char* refusal() {
        return System::separable ? nullptr : "its Hamiltonian is not of the form |p|^2/2 + V(q)";
    }
    static constexpr bool resumes = true;
    template <class System, class V>
    static void begin(const System&, Flow<V>&, const Coefficients&) {}

    template <class System, class V>
    static void step(const System& system, Flow<V>& f, const Coefficients& coefficients) {
        using S = ScalarOf<V>;
        Vec3<V> q = f.start.q(), p = f.start.p();
        V parameter = f.start_parameter;
        bool kick = coefficients.kick_first;
        for (const double fraction : coefficients.fractions) {
            const V t = f.h * V(S(fraction));
            if (kick) {
                const State<V> here = joined(f, q, p);
                p = retreat(p, t, system.dq(here));
                if (f.want_parameter) parameter = mul_add(t, system.pace(here), parameter);
                f.gradients += V(S(1));
            } else {
                q = advance(q, t, p);
            }
            kick = !kick;
        }
        f.end.set(q, p);
        f.end_parameter = System::rescaled ? parameter : f.start_parameter + f.h;
        f.solved = V(S(0)) <= V(S(0));
    }
};

/// ½(|p|² − p_t²) + K with K's flow in closed form, as Kerr–Schild metrics have it: drift first.
struct ExactSplit {
    template <class System>
    static constexpr const char* refusal() {
        if (System::rescaled) return "the exact split integrates H itself, not a rescaled one";
        return ExactlySplit<typename System::Hamiltonian> ? nullptr : "its Hamiltonian has no exact Kerr-Schild split";
    }
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
        f.end_parameter = f.start_parameter + f.h;
        f.solved = V(S(0)) <= V(S(0));
    }
};

}  // namespace kagero

/// Gauss–Legendre collocation: implicit, symplectic, symmetric, order 2s. Fixed-point iteration from the last step's extrapolated
/// stages; the stages are independent of each other, which keeps several operations in flight.
#pragma once

#include "kernels/stepping/gauss_table.h"
#include "kernels/stepping/implicit.h"

namespace kagero {

template <int s>
struct Gauss {
    static_assert(s <= max_stages);

    template <class System>
    static constexpr const char* refusal() { return nullptr; }

    /// Before the first step: every stage has the derivative at the start.
    template <class System, class V>
    static void begin(const System& system, Flow<V>& f) {
        system.derivatives(f.start, f.stage[0]);
        for (int i = 1; i < s; ++i)
            for (int k = 0; k < 6; ++k) f.stage[i][k] = f.stage[0][k];
    }

    template <class System, class V>
    static void step(const System& system, Flow<V>& f) {
        using S = ScalarOf<V>;
        V g[s][6];  // ∂K/∂q, ∂K/∂p at the stages
        extrapolate(f.stage, g);
        Convergence<V> convergence(f);
        V evaluations(S(0));
        for (int iteration = 0; iteration < Convergence<V>::max_iterations && any(convergence.open()); ++iteration) {
            f.open_iterations += count(convergence.open());
            f.issued_iterations += lane_count<V>;
            evaluations += pick(convergence.open(), V(S(s)), V(S(0)));
            convergence.update(iterate(system, f, convergence, g));
        }
        f.solved = !convergence.open();
        f.gradients += evaluations;
        finish(system, f, g);
    }

private:
    /// y + sign·h·Σ_j weight_j d_j: component k of a state, where q moves along +∂K/∂p and p along −∂K/∂q.
    template <class V, class W>
    KAGERO_INLINE static V moved(const Flow<V>& f, const V (&g)[s][6], const W& weight, int k) {
        using S = ScalarOf<V>;
        const int d = k < 3 ? k + 3 : k - 3;
        V sum = V(S(weight[0])) * g[0][d];
        for (int j = 1; j < s; ++j) sum = mul_add(V(S(weight[j])), g[j][d], sum);
        return k < 3 ? mul_add(f.h, sum, f.start.y[k]) : neg_mul_add(f.h, sum, f.start.y[k]);
    }

    template <class V>
    KAGERO_INLINE static void extrapolate(const V (&stage)[max_stages][6], V (&g)[s][6]) {
        using S = ScalarOf<V>;
        for (int k = 0; k < 6; ++k) {
            for (int i = 0; i < s; ++i) {
                V sum = V(S(gauss_table<s>.ahead[i][0])) * stage[0][k];
                for (int j = 1; j < s; ++j) sum = mul_add(V(S(gauss_table<s>.ahead[i][j])), stage[j][k], sum);
                g[i][k] = sum;
            }
        }
    }

    /// New stage derivatives from the old ones in every open lane; returns the relative change of the stages this makes.
    template <class System, class V>
    KAGERO_INLINE static V iterate(const System& system, const Flow<V>& f, const Convergence<V>& convergence, V (&g)[s][6]) {
        using S = ScalarOf<V>;
        State<V> y[s];
        for (int i = 0; i < s; ++i) {
            for (int k = 0; k < 6; ++k) y[i].y[k] = moved(f, g, gauss_table<s>.a[i], k);
            y[i].y[6] = f.start.y[6];
        }
        V change_q(S(0)), change_p(S(0));
        for (int i = 0; i < s; ++i) {
            V fresh[6];
            system.derivatives(y[i], fresh);
            for (int k = 0; k < 3; ++k) change_p = max(change_p, abs(fresh[k] - g[i][k]));
            for (int k = 3; k < 6; ++k) change_q = max(change_q, abs(fresh[k] - g[i][k]));
            for (int k = 0; k < 6; ++k) g[i][k] = pick(convergence.open(), fresh[k], g[i][k]);
        }
        return convergence.relative(abs(f.h) * change_q, abs(f.h) * change_p);
    }

    template <class System, class V>
    KAGERO_INLINE static void finish(const System& system, Flow<V>& f, const V (&g)[s][6]) {
        using S = ScalarOf<V>;
        for (int k = 0; k < 6; ++k) f.end.y[k] = moved(f, g, gauss_table<s>.b, k);
        f.end_parameter = f.start_parameter + f.h;
        if (System::rescaled && f.want_parameter) {
            V pace(S(0));
            for (int i = 0; i < s; ++i) {
                State<V> y;
                for (int k = 0; k < 6; ++k) y.y[k] = moved(f, g, gauss_table<s>.a[i], k);
                y.y[6] = f.start.y[6];
                pace = mul_add(V(S(gauss_table<s>.b[i])), system.pace(y), pace);
            }
            f.end_parameter = mul_add(f.h, pace, f.start_parameter);
        }
        for (int i = 0; i < s; ++i)
            for (int k = 0; k < 6; ++k) f.stage[i][k] = g[i][k];
    }
};

}  // namespace kagero

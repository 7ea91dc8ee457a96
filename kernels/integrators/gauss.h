/// Gauss–Legendre collocation: implicit, symplectic, symmetric, order 2s. Fixed-point iteration from the last step's
/// extrapolated stages; the stages are independent of each other, which keeps several operations in flight. Newton's
/// method takes what that leaves.
#pragma once

#include "kernels/integrators/carried.h"
#include "kernels/integrators/costs.h"
#include "kernels/integrators/implicit.h"
#include "kernels/integrators/shared.h"

#include <algorithm>

namespace kagero {

/// `fixed` stages, known to the compiler, or with 0 as many as the coefficients say.
template <int fixed>
struct Gauss {
    static constexpr Family family = Family::gauss;
    /// No stage lies on an end of the step.
    static constexpr bool stages_inside = true;
    static constexpr bool carries = true;
    template <class System>
    static constexpr const char* refusal() { return nullptr; }
    template <class System>
    static constexpr bool shareable() { return true; }
    /// Sums of s stages: 2 s − 1 operations in each component of a gradient; where the stage lies; how far it moved.
    static Operations operations(const Coefficients& c, const ProgramOperations& program) {
        const double s = c.gauss->stages, sum = phase_size * (2 * s - 1);
        const double placed = 2 * phase_size, compared = 2 * phase_size;
        return operations_in_space(program.derivatives + sum + placed + compared,
                                   program.event_functions + (s + 1) * sum + 30);
    }
    /// What the state cuts off is carried on.
    static constexpr RoundingCounts roundings(const Coefficients& c) { return {0, double(c.gauss->stages), 1}; }

    /// Before the first step: every stage has the derivative at the start.
    template <class System, class V, int N>
    static void begin(const System& system, StepperState<V, N>& f, const Coefficients& coefficients) {
        system.derivatives(f.start, f.stage[0]);
        for (int i = 1; i < stages(coefficients); ++i)
            for (int k = 0; k < phase_size; ++k) f.stage[i][k] = f.stage[0][k];
    }

    template <class System, class V, int N>
    static void step(const System& system, StepperState<V, N>& f, const Coefficients& coefficients) {
        using S = ScalarOf<V>;
        const int s = stages(coefficients);
        const GaussNumbers<S>& w = coefficients.gauss->template numbers<S>();
        PhaseGradient<V> g[room];  // ∂K/∂q, ∂K/∂p at the stages
        for (int i = 0; i < s; ++i) sum(f.stage, w.ahead[i], s, g[i]);
        auto&& prepared = prepare<V>(system, s);
        Convergence<V> convergence(f);
        V iterations(S(0));
        for (int iteration = 0; iteration < Convergence<V>::max_iterations && any(convergence.open()); ++iteration) {
            iterations += select(convergence.open(), V(S(1)), V(S(0)));
            ++f.issued_iterations;
            convergence.update(iterate(prepared, f, w, s, convergence, g));
        }
        f.solved = !convergence.open();
        f.gradients = fma(iterations, V(S(s)), f.gradients);
        f.open_iterations += iterations;
        if (any(convergence.open())) solve_rest(system, f, w, s, g);
        finish(system, f, w, s, g);
    }

    /// Dense output of the step in `f`.
    template <class V, int N = default_carried>
    static Curve<V> curve(const StepperState<V, N>& f, const Coefficients& coefficients) {
        return Shared<V, N>::collocation_curve(f, coefficients);
    }

private:
    static constexpr int room = fixed ? fixed : max_stages;
    static constexpr int stages(const Coefficients& coefficients) { return fixed ? fixed : coefficients.gauss->stages; }

    /// Σ_j weight_j g_j.
    template <class V, class S>
    KAGERO_INLINE static void sum(const PhaseGradient<V>* g, const S* weight, int s, PhaseGradient<V>& total) {
        for (int k = 0; k < phase_size; ++k) total[k] = V(weight[0]) * g[0][k];
        for (int j = 1; j < s; ++j)
            for (int k = 0; k < phase_size; ++k) total[k] = fma(V(weight[j]), g[j][k], total[k]);
    }
    /// y = start + h Σ_j weight_j f_j: q moves along +∂K/∂p, p along −∂K/∂q; `y(k)` is where component k belongs.
    template <class V, int N, class S, class Place>
    KAGERO_INLINE static void move(const StepperState<V, N>& f, const PhaseGradient<V>* g, const S* weight, int s,
                                   const Place& y) {
        PhaseGradient<V> total;
        sum(g, weight, s, total);
        for (int k = 0; k < space_size; ++k) {
            y(k) = fma(f.h, total[momentum(k)], f.start.y[k]);
            y(momentum(k)) = fnma(f.h, total[k], f.start.y[momentum(k)]);
        }
        y(component_pt) = f.start.pt();
    }
    template <class V, int N, class S>
    KAGERO_INLINE static void move(const StepperState<V, N>& f, const PhaseGradient<V>* g, const S* weight, int s,
                                   State<V>& y) {
        move(f, g, weight, s, [&y](int k) __attribute__((always_inline)) -> V& { return y.y[k]; });
    }

    /// A system that is interpreted has a way of its own to take all stages at once, which it prepares once for all
    /// iterations.
    template <class System>
    static constexpr bool at_once = requires(const System& system) { system.template derivatives_at<double>(1); };
    template <class V, class System>
    KAGERO_INLINE static decltype(auto) prepare(const System& system, int s) {
        if constexpr (at_once<System>) return system.template derivatives_at<V>(s);
        else return system;
    }

    /// New stage derivatives from the old ones in every open lane; returns the relative change of the stages this
    /// makes.
    template <class Prepared, class V, int N, class S>
    KAGERO_INLINE static V iterate(Prepared& prepared, const StepperState<V, N>& f, const GaussNumbers<S>& w, int s,
                                   const Convergence<V>& convergence, PhaseGradient<V> (&g)[room]) {
        V change_q(S(0)), change_p(S(0));
        const auto take = [&](int i, const PhaseGradient<V>& fresh) __attribute__((always_inline)) {
            for (int k = 0; k < space_size; ++k) change_p = max(change_p, abs(fresh[k] - g[i][k]));
            for (int k = space_size; k < phase_size; ++k) change_q = max(change_q, abs(fresh[k] - g[i][k]));
            for (int k = 0; k < phase_size; ++k) g[i][k] = select(convergence.open(), fresh[k], g[i][k]);
        };
        if constexpr (requires { prepared.run(); }) {
            for (int i = 0; i < s; ++i)
                move(
                    f, g, w.a[i], s, [&](int k) __attribute__((always_inline))->V & { return prepared.input(i, k); });
            prepared.run();
            for (int i = 0; i < s; ++i) {
                PhaseGradient<V> fresh;
                prepared.read(i, fresh);
                take(i, fresh);
            }
        } else {
            State<V> y[room];
            for (int i = 0; i < s; ++i) move(f, g, w.a[i], s, y[i]);
            for (int i = 0; i < s; ++i) {
                PhaseGradient<V> fresh;
                prepared.derivatives(y[i], fresh);
                take(i, fresh);
            }
        }
        return convergence.relative(abs(f.h) * change_q, abs(f.h) * change_p);
    }

    /// Rays that are not solved. Works on a copy, so that the stages of the others need not have an address.
    template <class System, class V, int N, class S>
    static void solve_rest(const System& system, StepperState<V, N>& f, const GaussNumbers<S>& w, int s,
                           PhaseGradient<V> (&g)[room]) {
        PhaseGradient<V> now[room];
        std::copy(&g[0][0], &g[0][0] + phase_size * s, &now[0][0]);
        Shared<V, N>::newton_stages(as_called<V>(system), f, w, s, &now[0][0], phase_size, 1);
        std::copy(&now[0][0], &now[0][0] + phase_size * s, &g[0][0]);
    }

    /// The end of the step, with what rounding cut off before (Kahan 1965): many small steps lose no more than few long
    /// ones.
    template <class V, int N, class S>
    KAGERO_INLINE static void finish_state(StepperState<V, N>& f, const PhaseGradient<V> (&g)[room],
                                           const GaussNumbers<S>& w, int s) {
        PhaseGradient<V> total;
        sum(g, w.b, s, total);
        f.end.pt() = f.start.pt();
        for (int k = 0; k < phase_size; ++k) {
            const V &slope = total[conjugate(k)], &cut_off = f.start.carry[k];
            const V change = k < space_size ? fma(f.h, slope, cut_off) : fnma(f.h, slope, cut_off);
            f.end.y[k] = f.start.y[k] + change;
            f.end.carry[k] = change - (f.end.y[k] - f.start.y[k]);
        }
    }

    template <class System, class V, int N, class S>
    KAGERO_INLINE static void finish(const System& system, StepperState<V, N>& f, const GaussNumbers<S>& w, int s,
                                     const PhaseGradient<V> (&g)[room]) {
        finish_state(f, g, w, s);
        carry_evenly(f);
        if (integrates_carried(system, f)) {
            auto carried = CarriedSums<V, N>::of_weights();
            for (int i = 0; i < s; ++i) {
                State<V> y;
                move(f, g, w.a[i], s, y);
                carried.add(system, V(w.b[i]), y);
            }
            carried.finish_weights(system, f);
        }
        for (int i = 0; i < s; ++i)
            for (int k = 0; k < phase_size; ++k) f.stage[i][k] = g[i][k];
    }
};

}  // namespace kagero

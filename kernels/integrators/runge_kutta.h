/// Explicit Runge–Kutta methods, with fixed step or with step control lane by lane: not symplectic, for comparison and
/// where a ray passes only once.
#pragma once

#include "kernels/integrators/carried.h"
#include "kernels/integrators/costs.h"
#include "kernels/integrators/implicit.h"
#include "kernels/integrators/shared.h"

namespace kagero {

/// Any table: coefficients are data, so that one copy of the derivative program serves them all.
struct RungeKutta {
    static constexpr Family family = Family::runge_kutta;
    template <class System>
    static constexpr const char* refusal() { return nullptr; }
    template <class System>
    static constexpr bool shareable() { return true; }
    static Operations operations(const Coefficients& c, const ProgramOperations& program) {
        double products = 0;
        for (int i = 0; i < c.table->stages; ++i) {
            products += (c.table->b[i] != 0) + (c.table->error[i] != 0);
            for (int j = 0; j < i; ++j) products += c.table->a[i][j] != 0;
        }
        return operations_in_space(program.derivatives, program.event_functions + 2 * phase_size * products);
    }
    static constexpr RoundingCounts roundings(const Coefficients& c) {
        double weight = 0;
        for (int i = 0; i < c.table->stages; ++i) weight += c.table->b[i] < 0 ? -c.table->b[i] : c.table->b[i];
        return {1, double(c.table->stages), weight};
    }
    static constexpr bool resumes = true;
    template <class System, class V, int N>
    static void begin(const System&, StepperState<V, N>&, const Coefficients&) {}

    template <class System, class V, int N>
    static void step(const System& system, StepperState<V, N>& f, const Coefficients& coefficients) {
        const ButcherTable& table = *coefficients.table;
        using S = ScalarOf<V>;
        PhaseGradient<V> g[max_rk_stages];
        auto carried = CarriedSums<V, N>::of_weights();
        for (int i = 0; i < table.stages; ++i) {
            State<V> y;
            if (i == 0) y = f.start;
            else move(f, g, table.a[i], i, y);
            system.derivatives(y, g[i]);
            if (integrates_carried(system, f)) carried.add(system, V(S(table.b[i])), y);
        }
        move(f, g, table.b, table.stages, f.end);
        carried.finish_weights(system, f);
        f.gradients += V(S(table.stages));
        f.solved = always<V>();
        if (table.estimate_order) control(f, g, table);
    }

private:
    /// Σ_j weight_j g_j over the stages with a weight; g as it comes, ∂K/∂q then ∂K/∂p.
    template <class V>
    KAGERO_INLINE static void sum(const PhaseGradient<V> (&g)[max_rk_stages], const double* weight, int stages,
                                  PhaseGradient<V>& total) {
        using S = ScalarOf<V>;
        for (V& t : total) t = V(S(0));
        for (int j = 0; j < stages; ++j) {
            if (weight[j] == 0) continue;
            const V w{S(weight[j])};
            for (int k = 0; k < phase_size; ++k) total[k] = fma(w, g[j][k], total[k]);
        }
    }
    /// y = start + h Σ weight_j f_j.
    template <class V, int N>
    KAGERO_INLINE static void move(const StepperState<V, N>& f, const PhaseGradient<V> (&g)[max_rk_stages],
                                   const double* weight, int stages, State<V>& y) {
        PhaseGradient<V> total;
        sum(g, weight, stages, total);
        for (int k = 0; k < space_size; ++k) {
            y.y[k] = fma(f.h, total[momentum(k)], f.start.y[k]);
            y.y[momentum(k)] = fnma(f.h, total[k], f.start.y[momentum(k)]);
        }
        y.pt() = f.start.pt();
    }

    /// x^(−1/n); of the eighth, which the costliest method asks for, in fewer operations.
    template <class V>
    KAGERO_INLINE static V inverse_root(const V& x, int n) {
        return n == 8 ? recip(sqrt(sqrt(sqrt(x)))) : exp(log(x) * V(ScalarOf<V>(-1.0 / n)));
    }

    /// Elementary step control (Hairer, Nørsett & Wanner 1993, §II.4), each lane for itself: a step whose estimated
    /// local error exceeds the tolerance, relative to 1 + |value|, is rejected, and the next length aims at it with a
    /// safety factor.
    template <class V, int N>
    KAGERO_INLINE static void control(StepperState<V, N>& f, const PhaseGradient<V> (&g)[max_rk_stages],
                                      const ButcherTable& table) {
        using S = ScalarOf<V>;
        PhaseGradient<V> total;
        V error(S(0));
        sum(g, table.error, table.stages, total);
        for (int k = 0; k < space_size; ++k) {
            error = max(error, abs(f.h * total[momentum(k)]) / (V(S(1)) + abs(f.end.y[k])));
            error = max(error, abs(f.h * total[k]) / (V(S(1)) + abs(f.end.y[momentum(k)])));
        }
        const V relative = max(error * V(S(1) / f.options.tolerance), V(S(1e-6)));
        const V factor = inverse_root(relative, table.estimate_order + 1);
        f.accepted = relative <= V(S(1));
        f.suggested = f.h * max(min(V(S(0.9)) * factor, V(S(4))), V(S(0.2)));
    }
};

}  // namespace kagero

/// Explicit Runge–Kutta methods with a fixed step, or with step control in each lane. They are not symplectic. They are
/// used for comparison, and for rays that pass only once through the region in which light bends.
#pragma once

#include "kernels/integrators/carried.h"
#include "kernels/integrators/costs.h"
#include "kernels/integrators/implicit.h"
#include "kernels/integrators/shared.h"

namespace kagero {

/// Stepper for any Butcher tableau. The tableau is data, so all methods share one copy of the derivative program.
struct RungeKutta {
    static constexpr MethodFamily family = MethodFamily::runge_kutta;
    template <class System>
    static constexpr const char* refusal() { return nullptr; }
    template <class System>
    static constexpr bool shareable() { return true; }
    /// Every nonzero coefficient takes a product and a sum per component of the gradient.
    static Operations operations(const Coefficients& c, const ProgramOperations& program) {
        double products = 0;
        for (int i = 0; i < c.table->stages; ++i) {
            products += (c.table->b[i] != 0) + (c.table->error[i] != 0);
            for (int j = 0; j < i; ++j) products += c.table->a[i][j] != 0;
        }
        return make_operations(program.derivatives, program.event_functions + 2 * phase_size * products);
    }
    static constexpr RoundingCounts rounding_counts(const Coefficients& c) {
        double weight = 0;
        for (int i = 0; i < c.table->stages; ++i) weight += c.table->b[i] < 0 ? -c.table->b[i] : c.table->b[i];
        return {1, double(c.table->stages), weight};
    }
    static constexpr bool steps_without_begin = true;
    template <class System, class V, int N>
    static void begin(const System&, StepperState<V, N>&, const Coefficients&) {}

    template <class System, class V, int N>
    static void step(const System& system, StepperState<V, N>& step, const Coefficients& coefficients) {
        const ButcherTable& table = *coefficients.table;
        using S = ScalarOf<V>;
        PhaseGradient<V> g[max_rk_stages];
        CarriedSums<V, N> carried;
        for (int i = 0; i < table.stages; ++i) {
            State<V> y;
            if (i == 0) y = step.start;
            else write_state(step, g, table.a[i], i, y);
            system.derivatives(y, g[i]);
            if (integrates_carried(system, step)) carried.add(system, V(S(table.b[i])), y);
        }
        write_state(step, g, table.b, table.stages, step.end);
        carried.finish_stages(system, step);
        step.gradients += V(S(table.stages));
        step.solved = all_lanes<V>();
        if (table.estimate_order) control(step, g, table);
    }

private:
    /// Writes Σ_j weight_j g_j to `total`; stages with weight 0 are skipped. The order of components is ∂K/∂q, ∂K/∂p.
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
    /// Writes start + h Σ_j weight_j (∂K/∂p, −∂K/∂q)_j to y.
    template <class V, int N>
    KAGERO_INLINE static void write_state(const StepperState<V, N>& step, const PhaseGradient<V> (&g)[max_rk_stages],
                                          const double* weight, int stages, State<V>& y) {
        PhaseGradient<V> total;
        sum(g, weight, stages, total);
        for (int k = 0; k < space_size; ++k) {
            y.y[k] = fma(step.h, total[momentum(k)], step.start.y[k]);
            y.y[momentum(k)] = fnma(step.h, total[k], step.start.y[momentum(k)]);
        }
        y.pt() = step.start.pt();
    }

    /// Returns x^(−1/n). For n = 8, as in rkf78, it uses square roots, which take fewer operations.
    template <class V>
    KAGERO_INLINE static V inverse_root(const V& x, int n) {
        return n == 8 ? recip(sqrt(sqrt(sqrt(x)))) : exp(log(x) * V(ScalarOf<V>(-1.0 / n)));
    }

    /// Applies elementary step control in each lane (Hairer, Nørsett & Wanner 1993, §II.4). The local error of each
    /// component x is estimated relative to a scale plus `value_weight` times |x|. A step is rejected if the greatest
    /// of these errors exceeds the tolerance. The suggested length of the next step aims at the tolerance with a safety
    /// factor.
    template <class V, int N>
    KAGERO_INLINE static void control(StepperState<V, N>& step, const PhaseGradient<V> (&g)[max_rk_stages],
                                      const ButcherTable& table) {
        using S = ScalarOf<V>;
        PhaseGradient<V> total;
        V error(S(0));
        sum(g, table.error, table.stages, total);
        const V weight(step.options.value_weight), position_scale(step.options.position_scale),
            momentum_scale(step.options.momentum_scale);
        for (int k = 0; k < space_size; ++k) {
            error = max(error, abs(step.h * total[momentum(k)]) / fma(weight, abs(step.end.y[k]), position_scale));
            error = max(error, abs(step.h * total[k]) / fma(weight, abs(step.end.y[momentum(k)]), momentum_scale));
        }
        const V relative = max(error * V(S(1) / step.options.tolerance), V(S(1e-6)));
        const V factor = inverse_root(relative, table.estimate_order + 1);
        step.accepted = relative <= V(S(1));
        step.suggested_length = step.h * max(min(V(S(0.9)) * factor, V(S(4))), V(S(0.2)));
    }
};

}  // namespace kagero

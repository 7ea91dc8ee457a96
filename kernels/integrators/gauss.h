/// Gauss–Legendre collocation: implicit, symplectic, symmetric, order 2s. The stages are solved by fixed-point
/// iteration, which starts from the extrapolated stages of the previous step. The stages of an iteration are
/// independent of each other, so the CPU can overlap their operations. Rays that do not converge are solved by Newton's
/// method.
#pragma once

#include "kernels/integrators/carried.h"
#include "kernels/integrators/costs.h"
#include "kernels/integrators/implicit.h"
#include "kernels/integrators/shared.h"

#include <algorithm>

namespace kagero {

/// Stepper for collocation with `fixed_stages` stages, a compile-time constant. If it is 0, the number of stages is
/// read from the coefficients.
template <int fixed_stages>
struct Gauss {
    static constexpr MethodFamily family = MethodFamily::gauss;
    /// No stage lies at an end of the step.
    static constexpr bool stages_inside = true;
    /// The memory is the rounding error of the state.
    static constexpr bool keeps_memory = true;
    template <class System>
    static constexpr const char* refusal() { return nullptr; }
    template <class System>
    static constexpr bool shareable() { return true; }
    /// Returns the numbers of floating-point operations. A sum over s stages takes 2 s − 1 operations per component of
    /// the gradient. Each iteration also computes the state of every stage and the change of its derivatives. At the
    /// end of a step, the compensated sum of the state takes 30 operations.
    static Operations operations(const Coefficients& c, const ProgramOperations& program) {
        const double s = c.gauss->stages, sum = phase_size * (2 * s - 1);
        const double stage_state = 2 * phase_size, change = 2 * phase_size;
        return make_operations(program.derivatives + sum + stage_state + change,
                               program.event_functions + (s + 1) * sum + 30);
    }
    /// The next step compensates the rounding error of the state, so the number of roundings of the state is 0.
    static constexpr RoundingCounts rounding_counts(const Coefficients& c) { return {0, double(c.gauss->stages), 1}; }

    /// Sets the derivatives at every stage to those at the start, as the initial guess of the first step.
    template <class System, class V, int N>
    static void begin(const System& system, StepperState<V, N>& step, const Coefficients& coefficients) {
        system.derivatives(step.start, step.stage[0]);
        for (int i = 1; i < stages(coefficients); ++i)
            for (int k = 0; k < phase_size; ++k) step.stage[i][k] = step.stage[0][k];
    }

    template <class System, class V, int N>
    static void step(const System& system, StepperState<V, N>& step, const Coefficients& coefficients) {
        using S = ScalarOf<V>;
        const int s = stages(coefficients);
        const GaussNumbers<S>& w = coefficients.gauss->template numbers<S>();
        PhaseGradient<V> g[stage_capacity];  // ∂K/∂(q, p) at the stages
        for (int i = 0; i < s; ++i) sum(step.stage, w.extrapolation[i], s, g[i]);
        auto&& evaluator = stage_evaluator<V>(system, s);
        Convergence<V> convergence(step);
        V iterations(S(0));
        for (int iteration = 0; iteration < Convergence<V>::max_iterations && any(convergence.unconverged());
             ++iteration) {
            iterations += select(convergence.unconverged(), V(S(1)), V(S(0)));
            ++step.issued_iterations;
            convergence.update(iterate(evaluator, step, w, s, convergence, g));
        }
        step.solved = !convergence.unconverged();
        step.gradients = fma(iterations, V(S(s)), step.gradients);
        step.lane_iterations += iterations;
        if (any(convergence.unconverged())) solve_unconverged(system, step, w, s, g);
        finish(system, step, w, s, g);
    }

    /// Returns the dense output of a step.
    template <class V, int N = default_carried>
    static Curve<V> curve(const StepperState<V, N>& step, const Coefficients& coefficients) {
        return SharedSolvers<V, N>::collocation_curve(step, coefficients);
    }
    /// Writes the state and dq/dτ at stage i of the last step.
    template <class V, int N = default_carried>
    static void stage_state(const StepperState<V, N>& step, const Coefficients& coefficients, int i, State<V>& y,
                            Vec3<V>& velocity) {
        const GaussNumbers<ScalarOf<V>>& w = coefficients.gauss->template numbers<ScalarOf<V>>();
        write_state(step, step.stage, w.a[i], stages(coefficients), y);
        velocity = velocity_in(step.stage[i]);
    }

private:
    static constexpr int stage_capacity = fixed_stages ? fixed_stages : max_stages;
    static constexpr int stages(const Coefficients& coefficients) {
        return fixed_stages ? fixed_stages : coefficients.gauss->stages;
    }

    /// Writes Σ_j weight_j g_j to `total`.
    template <class V, class S>
    KAGERO_INLINE static void sum(const PhaseGradient<V>* g, const S* weight, int s, PhaseGradient<V>& total) {
        for (int k = 0; k < phase_size; ++k) total[k] = V(weight[0]) * g[0][k];
        for (int j = 1; j < s; ++j)
            for (int k = 0; k < phase_size; ++k) total[k] = fma(V(weight[j]), g[j][k], total[k]);
    }
    /// Writes start + h Σ_j weight_j (∂K/∂p, −∂K/∂q)_j to a state; y(k) returns a reference to component k of the
    /// state.
    template <class V, int N, class S, class Target>
    KAGERO_INLINE static void write_state(const StepperState<V, N>& step, const PhaseGradient<V>* g, const S* weight,
                                          int s, const Target& y) {
        PhaseGradient<V> total;
        sum(g, weight, s, total);
        for (int k = 0; k < space_size; ++k) {
            y(k) = fma(step.h, total[momentum(k)], step.start.y[k]);
            y(momentum(k)) = fnma(step.h, total[k], step.start.y[momentum(k)]);
        }
        y(component_pt) = step.start.pt();
    }
    template <class V, int N, class S>
    KAGERO_INLINE static void write_state(const StepperState<V, N>& step, const PhaseGradient<V>* g, const S* weight,
                                          int s, State<V>& y) {
        write_state(step, g, weight, s, [&y](int k) __attribute__((always_inline)) -> V& { return y.y[k]; });
    }

    /// True for an interpreted system (kernels/formula), which evaluates the derivatives at all stages in one call.
    template <class System>
    static constexpr bool has_stage_evaluator =
        requires(const System& system) { system.template derivatives_at<double>(1); };
    /// Returns an object that evaluates the derivatives in all iterations of a step.
    template <class V, class System>
    KAGERO_INLINE static decltype(auto) stage_evaluator(const System& system, int s) {
        if constexpr (has_stage_evaluator<System>) return system.template derivatives_at<V>(s);
        else return system;
    }

    /// Performs one fixed-point iteration: computes new stage derivatives from the old ones in every lane that has not
    /// converged. Returns the relative change of the stages.
    template <class Evaluator, class V, int N, class S>
    KAGERO_INLINE static V iterate(Evaluator& evaluator, const StepperState<V, N>& step, const GaussNumbers<S>& w,
                                   int s, const Convergence<V>& convergence, PhaseGradient<V> (&g)[stage_capacity]) {
        V change_q(S(0)), change_p(S(0));
        const auto update = [&](int i, const PhaseGradient<V>& fresh) __attribute__((always_inline)) {
            for (int k = 0; k < space_size; ++k) change_p = max(change_p, abs(fresh[k] - g[i][k]));
            for (int k = space_size; k < phase_size; ++k) change_q = max(change_q, abs(fresh[k] - g[i][k]));
            for (int k = 0; k < phase_size; ++k) g[i][k] = select(convergence.unconverged(), fresh[k], g[i][k]);
        };
        if constexpr (requires { evaluator.run(); }) {
            for (int i = 0; i < s; ++i)
                write_state(step, g, w.a[i], s,
                            [&](int k) __attribute__((always_inline)) -> V& { return evaluator.input(i, k); });
            evaluator.run();
            for (int i = 0; i < s; ++i) {
                PhaseGradient<V> fresh;
                evaluator.read(i, fresh);
                update(i, fresh);
            }
        } else {
            State<V> y[stage_capacity];
            for (int i = 0; i < s; ++i) write_state(step, g, w.a[i], s, y[i]);
            for (int i = 0; i < s; ++i) {
                PhaseGradient<V> fresh;
                evaluator.derivatives(y[i], fresh);
                update(i, fresh);
            }
        }
        return convergence.relative(abs(step.h) * change_q, abs(step.h) * change_p);
    }

    /// Solves the stages of the rays that have not converged. A copy of the stages is passed to the solver, so that the
    /// compiler can keep the original in registers.
    template <class System, class V, int N, class S>
    static void solve_unconverged(const System& system, StepperState<V, N>& step, const GaussNumbers<S>& w, int s,
                                  PhaseGradient<V> (&g)[stage_capacity]) {
        PhaseGradient<V> copy[stage_capacity];
        std::copy(&g[0][0], &g[0][0] + phase_size * s, &copy[0][0]);
        SharedSolvers<V, N>::newton_stages(as_called<V>(system), step, w, s, &copy[0][0], phase_size, 1);
        std::copy(&copy[0][0], &copy[0][0] + phase_size * s, &g[0][0]);
    }

    /// Computes the state at the end of the step with compensated summation (Kahan 1965): the rounding error of the
    /// previous step is added. Many short steps then lose no more accuracy than a few long steps.
    template <class V, int N, class S>
    KAGERO_INLINE static void finish_state(StepperState<V, N>& step, const PhaseGradient<V> (&g)[stage_capacity],
                                           const GaussNumbers<S>& w, int s) {
        PhaseGradient<V> total;
        sum(g, w.b, s, total);
        step.end.pt() = step.start.pt();
        for (int k = 0; k < phase_size; ++k) {
            const V &gradient = total[conjugate(k)], &rounding = step.start.stepper_memory[k];
            const V change = k < space_size ? fma(step.h, gradient, rounding) : fnma(step.h, gradient, rounding);
            step.end.y[k] = step.start.y[k] + change;
            step.end.stepper_memory[k] = change - (step.end.y[k] - step.start.y[k]);
        }
    }

    /// Computes the state and the carried quantities at the end of the step, and stores the stage derivatives.
    template <class System, class V, int N, class S>
    KAGERO_INLINE static void finish(const System& system, StepperState<V, N>& step, const GaussNumbers<S>& w, int s,
                                     const PhaseGradient<V> (&g)[stage_capacity]) {
        finish_state(step, g, w, s);
        advance_parameter_only(step);
        if (integrates_carried(system, step)) {
            CarriedSums<V, N> carried;
            for (int i = 0; i < s; ++i) {
                State<V> y;
                write_state(step, g, w.a[i], s, y);
                carried.add(system, V(w.b[i]), y);
            }
            carried.finish_stages(system, step);
        }
        for (int i = 0; i < s; ++i)
            for (int k = 0; k < phase_size; ++k) step.stage[i][k] = g[i][k];
    }
};

}  // namespace kagero

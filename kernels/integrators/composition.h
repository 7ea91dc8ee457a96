/// Compositions of semi-implicit Euler, Satoh (2003), eq. (9), and its adjoint. Here τ is the length of a substep:
///
///     χ_τ :  p' = p − τ ∂K/∂q(q, p'),   q' = q + τ ∂K/∂p(q, p')
///     χ*_τ:  q' = q + τ ∂K/∂p(q', p),   p' = p − τ ∂K/∂q(q', p)
///
/// χ alone has order 1. χ*_{τ/2} χ_{τ/2} is self-adjoint and has order 2: it is the generalised Störmer–Verlet method
/// (Hairer, Lubich & Wanner 2006, §VI.3). Methods of higher order are compositions of χ and χ* with the fractions of
/// `fractions.h`. The recipe as printed, eqs. (11)–(15), uses χ without its adjoint and has only order 1.
#pragma once

#include "kernels/integrators/carried.h"
#include "kernels/integrators/costs.h"
#include "kernels/integrators/implicit.h"
#include "kernels/integrators/shared.h"

namespace kagero {

/// Stepper for compositions of χ and χ*. Each implicit half step is solved by fixed-point iteration, then by Newton's
/// method in the lanes that have not converged.
struct Composition {
    static constexpr MethodFamily family = MethodFamily::composition;
    static constexpr bool splits_gradient = true;
    template <class System>
    static constexpr const char* refusal() { return nullptr; }
    static Operations operations(const Coefficients&, const ProgramOperations& program) {
        return alternating_operations(program);
    }
    static constexpr RoundingCounts rounding_counts(const Coefficients& c) {
        return {double(c.fractions.size()), 1, weight_of(c.fractions)};
    }
    /// Returns true if a half step is implicit. Explicit steps consist almost only of calls of the derivative programs,
    /// so sharing their code saves nothing.
    template <class System>
    static constexpr bool shareable() { return System::force_needs_p || System::velocity_needs_q; }
    /// Stores ∂K/∂q as stage vector 0 and ∂K/∂p as stage vector 1: the initial guesses of the implicit solves.
    template <class System, class V, int N>
    static void begin(const System& system, StepperState<V, N>& step, const Coefficients&) {
        PhaseGradient<V> g;
        system.derivatives(step.start, g);
        step.set_stage_vector(0, force_in(g));
        step.set_stage_vector(1, velocity_in(g));
    }

    template <class System, class V, int N>
    static void step(const System& system, StepperState<V, N>& step, const Coefficients& coefficients) {
        using S = ScalarOf<V>;
        Vec3<V> q = step.start.q(), p = step.start.p();
        Vec3<V> force = step.stage_vector(0), velocity = step.stage_vector(1);
        CarriedSums<V, N> carried;
        step.solved = all_lanes<V>();
        for (std::size_t i = 0; i < coefficients.fractions.size(); ++i) {
            const V tau = step.h * V(S(coefficients.fractions[i]));
            if (i % 2 == 0) {
                if (integrates_carried(system, step)) carried.add(system, tau, make_state(step, q, p));
                p = kick(system, step, q, p, tau, force);
                velocity = system.gradient_p(make_state(step, q, p));
                q = advance(q, tau, velocity);
            } else {
                q = drift(system, step, q, p, tau, velocity);
                force = system.gradient_q(make_state(step, q, p));
                p = retreat(p, tau, force);
                if (integrates_carried(system, step)) carried.add(system, tau, make_state(step, q, p));
            }
            step.gradients += V(S(1));
        }
        step.end.set(q, p);
        carried.finish_substeps(system, step);
        step.set_stage_vector(0, force);
        step.set_stage_vector(1, velocity);
    }

private:
    /// Returns p' = p − τ ∂K/∂q(q, p'). `force` is the initial guess of ∂K/∂q.
    template <class System, class V, int N>
    KAGERO_INLINE static Vec3<V> kick(const System& system, StepperState<V, N>& step, const Vec3<V>& q,
                                      const Vec3<V>& p, const V& tau, const Vec3<V>& force) {
        auto force_of = force_at(system, step, q, p);
        const auto next = [&](const Vec3<V>& guess) __attribute__((always_inline)) {
            return retreat(p, tau, force_of(guess));
        };
        if constexpr (!System::force_needs_p) return count_evaluation(step, next(p));
        else return solve<HalfStep::kick>(system, step, q, p, tau, retreat(p, tau, force), next);
    }
    /// Returns q' = q + τ ∂K/∂p(q', p). `velocity` is the initial guess of ∂K/∂p.
    template <class System, class V, int N>
    KAGERO_INLINE static Vec3<V> drift(const System& system, StepperState<V, N>& step, const Vec3<V>& q,
                                       const Vec3<V>& p, const V& tau, const Vec3<V>& velocity) {
        auto velocity_of = velocity_at(system, step, q, p);
        const auto next = [&](const Vec3<V>& guess) __attribute__((always_inline)) {
            return advance(q, tau, velocity_of(guess));
        };
        if constexpr (!System::velocity_needs_q) return count_evaluation(step, next(q));
        else return solve<HalfStep::drift>(system, step, q, p, tau, advance(q, tau, velocity), next);
    }
    /// Returns ∂K/∂q at fixed q as a function of p. An interpreted system (kernels/formula) evaluates the operations
    /// that do not depend on p only once.
    template <class System, class V, int N>
    KAGERO_INLINE static auto force_at(const System& system, const StepperState<V, N>& step, const Vec3<V>& q,
                                       const Vec3<V>& p) {
        if constexpr (requires { system.prepared_force(step.start); })
            return system.prepared_force(make_state(step, q, p));
        else return [&system, &step, &q ](const Vec3<V>& guess) __attribute__((always_inline)) {
                return system.gradient_q(make_state(step, q, guess));
            };
    }
    /// Returns ∂K/∂p at fixed p as a function of q.
    template <class System, class V, int N>
    KAGERO_INLINE static auto velocity_at(const System& system, const StepperState<V, N>& step, const Vec3<V>& q,
                                          const Vec3<V>& p) {
        if constexpr (requires { system.prepared_velocity(step.start); })
            return system.prepared_velocity(make_state(step, q, p));
        else return [&system, &step, &p ](const Vec3<V>& guess) __attribute__((always_inline)) {
                return system.gradient_p(make_state(step, guess, p));
            };
    }
    /// Counts one gradient evaluation and returns x, which was computed with it.
    template <class V, int N>
    KAGERO_INLINE static Vec3<V> count_evaluation(StepperState<V, N>& step, const Vec3<V>& x) {
        step.gradients += V(ScalarOf<V>(1));
        return x;
    }

    /// Returns the solution of x = next(x), where x is p' for a kick and q' for a drift. The fixed-point iteration has
    /// a convergence test in each lane. Lanes that do not converge are solved by Newton's method.
    template <HalfStep half, class System, class V, int N, class Next>
    KAGERO_INLINE static Vec3<V> solve(const System& system, StepperState<V, N>& step, const Vec3<V>& q,
                                       const Vec3<V>& p, const V& tau, const Vec3<V>& guess, const Next& next) {
        using S = ScalarOf<V>;
        Convergence<V> convergence(step);
        // All lanes iterate, but converged lanes discard the result. The iterations therefore do not depend on the
        // convergence tests, and the CPU can overlap both. Only every second iteration is tested, because a test costs
        // a large part of an iteration.
        Vec3<V> x = guess, iterate = guess;
        V evaluations(S(0));
        int i = 0;
        while (i < Convergence<V>::max_iterations && any(convergence.unconverged())) {
            i += 2;
            evaluations = select(convergence.unconverged(), V(S(i)), evaluations);
            const Vec3<V> previous = next(iterate);
            iterate = next(previous);
            x = select<V>(convergence.unconverged(), iterate, x);
            const V change = greatest_component(iterate - previous);
            convergence.update_every_second(half == HalfStep::kick ? convergence.relative_p(change)
                                                                   : convergence.relative_q(change));
        }
        if constexpr (half == HalfStep::kick) {
            // A solution whose distance from p is of the order of |p| may be a second solution of the equation. These
            // lanes are solved again by Newton's method, which tests the eigenvalues of the Jacobian.
            convergence.mark_unconverged(convergence.relative_p(greatest_component(x - p)) > V(S(0.5)));
        }
        step.gradients += evaluations;
        step.lane_iterations += evaluations;
        step.issued_iterations += i;
        if (any(convergence.unconverged())) {
            const MaskOf<V> unconverged = convergence.unconverged(), solved = step.solved;
            const V gradients = step.gradients, iterations = step.lane_iterations;
            // The arguments are copied so that the variables of the loop above stay in registers.
            const Vec3<V> q_copy = q, p_copy = p;
            const V tau_copy = tau;
            const Vec3<V> solution = SharedSolvers<V, N>::newton(
                half, as_called<V>(system), step, q_copy, p_copy, tau_copy, half == HalfStep::kick ? p_copy : q_copy);
            x = select<V>(unconverged, solution, x);
            step.solved = solved & (step.solved | !unconverged);
            step.gradients = select(unconverged, step.gradients, gradients);
            step.lane_iterations = select(unconverged, step.lane_iterations, iterations);
        }
        return x;
    }
};

}  // namespace kagero

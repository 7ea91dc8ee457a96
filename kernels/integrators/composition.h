/// Compositions of semi-implicit Euler, Satoh (2003), eq. (9), and its adjoint.
///
///     χ_τ :  p' = p − τ ∂H/∂q(q, p'),   q' = q + τ ∂H/∂p(q, p')
///     χ*_τ:  q' = q + τ ∂H/∂p(q', p),   p' = p − τ ∂H/∂q(q', p)
///
/// χ alone is of order 1; χ*_{τ/2} χ_{τ/2} is self-adjoint and of order 2, the generalised Störmer–Verlet method
/// (Hairer, Lubich & Wanner 2006, §VI.3), and higher orders are compositions of it with the fractions of `fractions.h`.
/// The printed recipe, eqs. (11)–(15) with χ for every part, stays at order 1.
#pragma once

#include "kernels/integrators/carried.h"
#include "kernels/integrators/costs.h"
#include "kernels/integrators/implicit.h"
#include "kernels/integrators/shared.h"

namespace kagero {

struct Composition {
    static constexpr Family family = Family::composition;
    static constexpr bool takes_sides = true;
    template <class System>
    static constexpr const char* refusal() { return nullptr; }
    static Operations operations(const Coefficients&, const ProgramOperations& program) {
        return operations_in_turn(program);
    }
    static constexpr RoundingCounts roundings(const Coefficients& c) {
        return {double(c.fractions.size()), 1, weight_of(c.fractions)};
    }
    /// Explicit, it is little more than the programs it calls.
    template <class System>
    static constexpr bool shareable() { return System::force_needs_p || System::velocity_needs_q; }
    /// stage[0][0..2] carries ∂K/∂q, stage[1][0..2] carries ∂K/∂p, as starts of the implicit solves.
    template <class System, class V, int N>
    static void begin(const System& system, StepperState<V, N>& f, const Coefficients&) {
        PhaseGradient<V> g;
        system.derivatives(f.start, g);
        for (int k = 0; k < space_size; ++k) f.stage[0][k] = g[k], f.stage[1][k] = g[momentum(k)];
    }

    template <class System, class V, int N>
    static void step(const System& system, StepperState<V, N>& f, const Coefficients& coefficients) {
        using S = ScalarOf<V>;
        Vec3<V> q = f.start.q(), p = f.start.p();
        Vec3<V> force = force_in(f.stage[0]), velocity = force_in(f.stage[1]);
        auto carried = CarriedSums<V, N>::of_lengths(f);
        f.solved = always<V>();
        for (std::size_t i = 0; i < coefficients.fractions.size(); ++i) {
            const V tau = f.h * V(S(coefficients.fractions[i]));
            if (i % 2 == 0) {
                if (integrates_carried(system, f)) carried.add(system, tau, joined(f, q, p));
                p = kick(system, f, q, p, tau, force);
                velocity = system.dp(joined(f, q, p));
                q = advance(q, tau, velocity);
            } else {
                q = drift(system, f, q, p, tau, velocity);
                force = system.dq(joined(f, q, p));
                p = retreat(p, tau, force);
                if (integrates_carried(system, f)) carried.add(system, tau, joined(f, q, p));
            }
            f.gradients += V(S(1));
        }
        f.end.set(q, p);
        carried.finish_lengths(system, f);
        f.stage[0][0] = force.x, f.stage[0][1] = force.y, f.stage[0][2] = force.z;
        f.stage[1][0] = velocity.x, f.stage[1][1] = velocity.y, f.stage[1][2] = velocity.z;
    }

private:
    /// p' = p − τ ∂K/∂q(q, p'); `force` is the first guess of the gradient.
    template <class System, class V, int N>
    KAGERO_INLINE static Vec3<V> kick(const System& system, StepperState<V, N>& f, const Vec3<V>& q, const Vec3<V>& p,
                                      const V& tau, const Vec3<V>& force) {
        auto force_here = force_at(system, f, q, p);
        const auto next = [&](const Vec3<V>& guess) __attribute__((always_inline)) {
            return retreat(p, tau, force_here(guess));
        };
        if constexpr (!System::force_needs_p) return evaluated(f, next(p));
        else return solve<Side::kick>(system, f, q, p, tau, retreat(p, tau, force), next);
    }
    /// q' = q + τ ∂K/∂p(q', p).
    template <class System, class V, int N>
    KAGERO_INLINE static Vec3<V> drift(const System& system, StepperState<V, N>& f, const Vec3<V>& q, const Vec3<V>& p,
                                       const V& tau, const Vec3<V>& velocity) {
        auto velocity_here = velocity_at(system, f, q, p);
        const auto next = [&](const Vec3<V>& guess) __attribute__((always_inline)) {
            return advance(q, tau, velocity_here(guess));
        };
        if constexpr (!System::velocity_needs_q) return evaluated(f, next(q));
        else return solve<Side::drift>(system, f, q, p, tau, advance(q, tau, velocity), next);
    }
    /// ∂K/∂q at q as a function of p, and ∂K/∂p with p as one of q. A system that is interpreted prepares what does not
    /// change.
    template <class System, class V, int N>
    KAGERO_INLINE static auto force_at(const System& system, const StepperState<V, N>& f, const Vec3<V>& q,
                                       const Vec3<V>& p) {
        if constexpr (requires { system.prepared_force(f.start); }) return system.prepared_force(joined(f, q, p));
        else return [&system, &f, &q ](const Vec3<V>& guess) __attribute__((always_inline)) {
                return system.dq(joined(f, q, guess));
            };
    }
    template <class System, class V, int N>
    KAGERO_INLINE static auto velocity_at(const System& system, const StepperState<V, N>& f, const Vec3<V>& q,
                                          const Vec3<V>& p) {
        if constexpr (requires { system.prepared_velocity(f.start); }) return system.prepared_velocity(joined(f, q, p));
        else return [&system, &f, &p ](const Vec3<V>& guess) __attribute__((always_inline)) {
                return system.dp(joined(f, guess, p));
            };
    }
    template <class V, int N>
    KAGERO_INLINE static Vec3<V> evaluated(StepperState<V, N>& f, const Vec3<V>& x) {
        f.gradients += V(ScalarOf<V>(1));
        return x;
    }

    /// Fixed-point iteration x = next(x), lane by lane; lanes that it leaves open are tried again by Newton's method.
    template <Side side, class System, class V, int N, class Next>
    KAGERO_INLINE static Vec3<V> solve(const System& system, StepperState<V, N>& f, const Vec3<V>& q, const Vec3<V>& p,
                                       const V& tau, const Vec3<V>& guess, const Next& next) {
        using S = ScalarOf<V>;
        Convergence<V> convergence(f);
        // Converged lanes iterate on, unheard: the next iterations need not wait for the test of these. Only every
        // second one is tested, as a test is no small part of an iteration.
        Vec3<V> x = guess, iterate = guess;
        V evaluations(S(0));
        int i = 0;
        while (i < Convergence<V>::max_iterations && any(convergence.open())) {
            i += 2;
            evaluations = select(convergence.open(), V(S(i)), evaluations);
            const Vec3<V> last = next(iterate);
            iterate = next(last);
            x = select<V>(convergence.open(), iterate, x);
            const V change = greatest_difference(iterate, last);
            convergence.update_second(side == Side::kick ? convergence.relative_p(change)
                                                         : convergence.relative_q(change));
        }
        if constexpr (side == Side::kick) {
            // A solution as far away as p is large may be a second root: Newton's method, which looks at the Jacobian,
            // decides.
            convergence.reopen(convergence.relative_p(greatest_difference(x, p)) > V(S(0.5)));
        }
        f.gradients += evaluations;
        f.open_iterations += evaluations, f.issued_iterations += i;
        if (any(convergence.open())) {
            const MaskOf<V> open = convergence.open(), solved = f.solved;
            const V gradients = f.gradients, iterations = f.open_iterations;
            // Copies, so that the variables of the loop above stay in registers.
            const Vec3<V> q_now = q, p_now = p;
            const V tau_now = tau;
            const Vec3<V> other = Shared<V, N>::newton(side, as_called<V>(system), f, q_now, p_now, tau_now,
                                                       side == Side::kick ? p_now : q_now);
            x = select<V>(open, other, x);
            f.solved = solved & (f.solved | !open);
            f.gradients = select(open, f.gradients, gradients),
            f.open_iterations = select(open, f.open_iterations, iterations);
        }
        return x;
    }
};

}  // namespace kagero

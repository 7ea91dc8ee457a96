/// Newton's method for an implicit half step of Satoh (2003), eq. (9), as in §3.2 of that paper: three unknowns per
/// ray, with the Jacobian from second derivatives of K.
#pragma once

#include "kernels/integrators/implicit.h"
#include "kernels/integrators/shared.h"

namespace kagero {

/// Returns the solution x of J x = r for a 3×3 matrix J, by Cramer's rule. Writes the determinant of J to
/// `determinant`.
template <class V>
KAGERO_INLINE Vec3<V> solve3(const V (&j)[9], const Vec3<V>& r, V& determinant) {
    const V c0 = j[4] * j[8] - j[5] * j[7], c1 = j[5] * j[6] - j[3] * j[8], c2 = j[3] * j[7] - j[4] * j[6];
    determinant = j[0] * c0 + j[1] * c1 + j[2] * c2;
    const V inverse = recip(determinant);
    const V x = c0 * r.x + (j[2] * j[7] - j[1] * j[8]) * r.y + (j[1] * j[5] - j[2] * j[4]) * r.z;
    const V y = c1 * r.x + (j[0] * j[8] - j[2] * j[6]) * r.y + (j[2] * j[3] - j[0] * j[5]) * r.z;
    const V z = c2 * r.x + (j[1] * j[6] - j[0] * j[7]) * r.y + (j[0] * j[4] - j[1] * j[3]) * r.z;
    return {inverse * x, inverse * y, inverse * z};
}

/// Returns the lanes in which all eigenvalues of J have positive real parts. The Routh–Hurwitz conditions are
/// trace > 0, determinant > 0, and trace · minors > determinant, where `minors` is the sum of the principal 2×2 minors.
template <class V>
KAGERO_INLINE MaskOf<V> eigenvalues_positive(const V (&j)[9], const V& determinant) {
    const V zero(ScalarOf<V>(0)), trace = j[0] + j[4] + j[8];
    const V minors = (j[4] * j[8] - j[5] * j[7]) + (j[0] * j[8] - j[2] * j[6]) + (j[0] * j[4] - j[1] * j[3]);
    return (trace > zero) & (determinant > zero) & (trace * minors > determinant);
}

/// Solves x = p − τ ∂K/∂q(q, x) for a kick, or x = q + τ ∂K/∂p(x, p) for a drift, from the initial guess x; τ is the
/// length of the half step. The Jacobian of the residual is I + τ M for a kick and I − τ Mᵀ for a drift, where
/// M = ∂²K/∂q∂p. As τ grows from 0, the solution moves continuously away from p or q, and the eigenvalues of the
/// Jacobian at the solution keep positive real parts. The real parts are required to be positive at the initial guess
/// and at every iterate. Otherwise the iteration could converge to another solution.
template <class V, int N>
Vec3<V> SharedSolvers<V, N>::newton(HalfStep half, const CalledSystem<V, N>& system, StepperState<V, N>& step,
                             const Vec3<V>& q, const Vec3<V>& p, const V& tau, Vec3<V> x) {
    constexpr int max_iterations = 12;
    Convergence<V> convergence(step);
    MaskOf<V> right_solution = all_lanes<V>();  // lanes in which the eigenvalues were positive in all iterations
    for (int i = 0; i < max_iterations && any(convergence.unconverged()); ++i) {
        step.lane_iterations += select(convergence.unconverged(), V(S(1)), V(S(0)));
        ++step.issued_iterations;
        step.gradients += select(convergence.unconverged(), V(S(2)), V(S(0)));
        const State<V> s = half == HalfStep::kick ? make_state(step, q, x) : make_state(step, x, p);
        V m[9], j[9], determinant;
        system.mixed(s, m);
        for (int k = 0; k < 9; ++k) {
            const V entry = half == HalfStep::kick ? tau * m[k] : -(tau * m[3 * (k % 3) + k / 3]);
            j[k] = k % 4 == 0 ? V(S(1)) + entry : entry;
        }
        const Vec3<V> next = half == HalfStep::kick ? retreat(p, tau, system.gradient_q(s))
                                                    : advance(q, tau, system.gradient_p(s));
        const Vec3<V> fresh = x - solve3(j, x - next, determinant);
        const V change = greatest_component(fresh - x);
        right_solution = right_solution & (eigenvalues_positive(j, determinant) | !convergence.unconverged());
        x = select<V>(convergence.unconverged(), fresh, x);
        convergence.update_quadratic(half == HalfStep::kick ? convergence.relative_p(change)
                                                            : convergence.relative_q(change));
    }
    step.solved = step.solved & !convergence.unconverged() & right_solution;
    return x;
}

}  // namespace kagero

/// Newton's method for the implicit halves of eq. (9), three unknowns per ray, with the Jacobian from the tape (Satoh
/// 2003, §3.2).
#pragma once

#include "kernels/integrators/implicit.h"
#include "kernels/integrators/shared.h"

namespace kagero {

/// x with J x = r for a 3×3 matrix by Cramer's rule; `determinant` of J.
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

/// Whether all eigenvalues of J have positive real parts (Routh–Hurwitz): trace > 0, determinant > 0, trace · minors >
/// determinant.
template <class V>
KAGERO_INLINE MaskOf<V> is_positive(const V (&j)[9], const V& determinant) {
    const V zero(ScalarOf<V>(0)), trace = j[0] + j[4] + j[8];
    const V minors = (j[4] * j[8] - j[5] * j[7]) + (j[0] * j[8] - j[2] * j[6]) + (j[0] * j[4] - j[1] * j[3]);
    return (trace > zero) & (determinant > zero) & (trace * minors > determinant);
}

/// x with x = next(x), where next is one of the two sides, from the guess x. The Jacobian is I + τ M for a kick and I −
/// τ Mᵀ for a drift, M = ∂²K/∂q∂p. Along the solution that grows out of the start as τ grows from zero its eigenvalues
/// stay positive; they must be so at the start and at every iterate, or a second root, beyond a fold, might be taken.
template <class V, int N>
Vec3<V> Shared<V, N>::newton(Side side, const CalledSystem<V, N>& system, StepperState<V, N>& f, const Vec3<V>& q,
                             const Vec3<V>& p, const V& tau, Vec3<V> x) {
    constexpr int max_iterations = 12;
    Convergence<V> convergence(f);
    MaskOf<V> right_branch = always<V>();
    for (int i = 0; i < max_iterations && any(convergence.open()); ++i) {
        f.open_iterations += select(convergence.open(), V(S(1)), V(S(0)));
        ++f.issued_iterations;
        f.gradients += select(convergence.open(), V(S(2)), V(S(0)));
        const State<V> s = side == Side::kick ? joined(f, q, x) : joined(f, x, p);
        V m[9], j[9], determinant;
        system.mixed(s, m);
        for (int k = 0; k < 9; ++k) {
            const V entry = side == Side::kick ? tau * m[k] : -(tau * m[3 * (k % 3) + k / 3]);
            j[k] = k % 4 == 0 ? V(S(1)) + entry : entry;
        }
        const Vec3<V> next = side == Side::kick ? retreat(p, tau, system.dq(s)) : advance(q, tau, system.dp(s));
        const Vec3<V> fresh = x - solve3(j, x - next, determinant);
        const V change = greatest_difference(fresh, x);
        right_branch = right_branch & (is_positive(j, determinant) | !convergence.open());
        x = select<V>(convergence.open(), fresh, x);
        convergence.update_quadratic(side == Side::kick ? convergence.relative_p(change)
                                                        : convergence.relative_q(change));
    }
    f.solved = f.solved & !convergence.open() & right_branch;
    return x;
}

}  // namespace kagero

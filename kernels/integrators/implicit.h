/// Convergence of fixed-point iterations, lane by lane. A lane that has converged is frozen while others go on, so that
/// no ray's result depends on its neighbours.
#pragma once

#include "kernels/integrators/stepper_state.h"

namespace kagero {

template <class V>
class Convergence {
    using S = ScalarOf<V>;

public:
    static constexpr int max_iterations = 60;

    /// Changes are measured relative to |q|₁ + |h dq/dτ|₁ and |p|₁ at the start of the step.
    template <int N>
    KAGERO_INLINE explicit Convergence(const StepperState<V, N>& f)
        : Convergence(f.start, f.h, f.start.velocity, f.options.solver_tolerance) {}
    KAGERO_INLINE Convergence(const State<V>& start, const V& h, const Vec3<V>& velocity, S tolerance)
        : tolerance_(max(tolerance, epsilon)),
          inverse_q_(inverse_size(fma(abs(h), size(velocity), size(start.q())))),
          inverse_p_(inverse_size(size(start.p()))),
          open_(always<V>()),
          previous_(V(S(0))) {}

    /// Lanes that still iterate.
    KAGERO_INLINE const MaskOf<V>& open() const { return open_; }
    /// Relative size of a change of q by dq and of p by dp (greatest components).
    KAGERO_INLINE V relative(const V& dq, const V& dp) const { return max(dq * inverse_q_, dp * inverse_p_); }
    KAGERO_INLINE V relative_q(const V& dq) const { return dq * inverse_q_; }
    KAGERO_INLINE V relative_p(const V& dp) const { return dp * inverse_p_; }

    /// Takes the relative change of this iteration. Iterations contract linearly, by about change/previous: the change
    /// that would come next is change²/previous. At the level of rounding a change that shrinks no more is accepted as
    /// well.
    KAGERO_INLINE void update(const V& change) {
        // change² ≤ tolerance · max(change, previous): small enough now, or next time.
        close(change * change <= V(tolerance_) * max(change, previous_), change);
    }
    /// The same where only every second iteration is looked at, by which changes shrink as change/previous =
    /// contraction²: the next change is √(change³/previous).
    KAGERO_INLINE void update_second(const V& change) {
        close(change * change * change <= V(tolerance_ * tolerance_) * max(change, previous_), change);
    }
    /// The same where iterations converge quadratically (Newton): the next change is about the square of this one.
    KAGERO_INLINE void update_quadratic(const V& change) { close(change * change <= V(tolerance_), change); }

    /// A change so small may be all that rounding lets be.
    KAGERO_INLINE MaskOf<V> is_rounding(const V& change) const { return change <= V(S(64) * epsilon); }

    /// Lanes whose solution is not to be trusted count as not converged.
    KAGERO_INLINE void reopen(const MaskOf<V>& lanes) { open_ = open_ | lanes; }
private:
    static constexpr S epsilon = machine_epsilon<S>;
    KAGERO_INLINE void close(const MaskOf<V>& small, const V& change) {
        const MaskOf<V> settled = is_rounding(change) & (previous_ <= change + change);
        open_ = open_ & !((small | settled) & (change <= V(S(1))));  // infinite changes may count as small
        previous_ = change;
    }
    KAGERO_INLINE static V size(const Vec3<V>& a) { return abs(a.x) + abs(a.y) + abs(a.z); }
    KAGERO_INLINE static V inverse_size(const V& a) { return recip(max(a, V(S(std::numeric_limits<float>::min())))); }

    S tolerance_;
    V inverse_q_, inverse_p_;
    MaskOf<V> open_;
    V previous_;
};

/// The state of rays at q with momentum p.
template <class V, int N>
KAGERO_INLINE State<V> joined(const StepperState<V, N>& f, const Vec3<V>& q, const Vec3<V>& p) {
    return {{q.x, q.y, q.z, p.x, p.y, p.z, f.start.pt()}};
}

/// Greatest component of |a − b|.
template <class V>
KAGERO_INLINE V greatest_difference(const Vec3<V>& a, const Vec3<V>& b) {
    return max(max(abs(a.x - b.x), abs(a.y - b.y)), abs(a.z - b.z));
}
template <class V>
KAGERO_INLINE Vec3<V> select(const MaskOf<V>& m, const Vec3<V>& a, const Vec3<V>& b) {
    return {select(m, a.x, b.x), select(m, a.y, b.y), select(m, a.z, b.z)};
}
/// a + s·b.
template <class V>
KAGERO_INLINE Vec3<V> advance(const Vec3<V>& a, const V& s, const Vec3<V>& b) {
    return {fma(s, b.x, a.x), fma(s, b.y, a.y), fma(s, b.z, a.z)};
}
/// a − s·b.
template <class V>
KAGERO_INLINE Vec3<V> retreat(const Vec3<V>& a, const V& s, const Vec3<V>& b) {
    return {fnma(s, b.x, a.x), fnma(s, b.y, a.y), fnma(s, b.z, a.z)};
}

}  // namespace kagero

/// Convergence of the iterations for implicit stages, lane by lane. A lane that has converged is frozen while other
/// lanes iterate. The result of a ray therefore does not depend on the other lanes.
#pragma once

#include "kernels/integrators/stepper_state.h"

namespace kagero {

/// Convergence test of one implicit solve.
template <class V>
class Convergence {
    using S = ScalarOf<V>;

public:
    static constexpr int max_iterations = 60;

    /// Initialises the test. Changes are measured relative to |q|₁ + |h dq/dτ|₁ and |p|₁ at the start of the step.
    template <int N>
    KAGERO_INLINE explicit Convergence(const StepperState<V, N>& step)
        : Convergence(step.start, step.h, step.start.velocity, step.options.solver_tolerance) {}
    KAGERO_INLINE Convergence(const State<V>& start, const V& h, const Vec3<V>& velocity, S tolerance)
        : tolerance_(max(tolerance, epsilon)),
          inverse_q_(inverse_size(fma(abs(h), size(velocity), size(start.q())))),
          inverse_p_(inverse_size(size(start.p()))),
          unconverged_(all_lanes<V>()),
          previous_(V(S(0))) {}

    /// Returns the lanes that have not converged.
    KAGERO_INLINE const MaskOf<V>& unconverged() const { return unconverged_; }
    /// Returns the relative size of a change of q and p. `dq` and `dp` are the greatest components of the change.
    KAGERO_INLINE V relative(const V& dq, const V& dp) const { return max(dq * inverse_q_, dp * inverse_p_); }
    /// Return the relative size of a change of q alone, or of p alone.
    KAGERO_INLINE V relative_q(const V& dq) const { return dq * inverse_q_; }
    KAGERO_INLINE V relative_p(const V& dp) const { return dp * inverse_p_; }

    /// Updates the test with the relative change of this iteration. The iteration contracts linearly, by about
    /// change/previous, so the next change would be about change²/previous. A change at the level of rounding that no
    /// longer shrinks is accepted as well.
    KAGERO_INLINE void update(const V& change) {
        // A lane converges if this change or the estimated next change is below the tolerance: change² ≤ tolerance ·
        // max(change, previous).
        mark_converged(change * change <= V(tolerance_) * max(change, previous_), change);
    }
    /// Updates the test, if it is called only for every second iteration. change/previous is then the square of the
    /// contraction factor, and the next change is about √(change³/previous).
    KAGERO_INLINE void update_second(const V& change) {
        mark_converged(change * change * change <= V(tolerance_ * tolerance_) * max(change, previous_), change);
    }
    /// Updates the test of an iteration that converges quadratically (Newton): the next change is about the square of
    /// this one.
    KAGERO_INLINE void update_quadratic(const V& change) {
        mark_converged(change * change <= V(tolerance_), change);
    }

    /// Returns the lanes in which a change is so small that it may consist of rounding errors alone.
    KAGERO_INLINE MaskOf<V> is_rounding(const V& change) const { return change <= V(S(64) * epsilon); }

    /// Marks lanes as not converged, because their solution cannot be trusted.
    KAGERO_INLINE void mark_unconverged(const MaskOf<V>& lanes) { unconverged_ = unconverged_ | lanes; }

private:
    static constexpr S epsilon = machine_epsilon<S>;
    /// Marks the lanes of `small` as converged, and lanes whose change is due to rounding and no longer shrinks.
    KAGERO_INLINE void mark_converged(const MaskOf<V>& small, const V& change) {
        const MaskOf<V> at_rounding = is_rounding(change) & (previous_ <= change + change);
        unconverged_ = unconverged_ & !((small | at_rounding) & (change <= V(S(1))));  // excludes infinite changes
        previous_ = change;
    }
    KAGERO_INLINE static V size(const Vec3<V>& a) { return abs(a.x) + abs(a.y) + abs(a.z); }
    KAGERO_INLINE static V inverse_size(const V& a) { return recip(max(a, V(S(std::numeric_limits<float>::min())))); }

    S tolerance_;
    V inverse_q_, inverse_p_;
    MaskOf<V> unconverged_;
    V previous_;
};

/// Returns the state with position q and momentum p; p_t is that of the start of the step.
template <class V, int N>
KAGERO_INLINE State<V> make_state(const StepperState<V, N>& step, const Vec3<V>& q, const Vec3<V>& p) {
    return {{q.x, q.y, q.z, p.x, p.y, p.z, step.start.pt()}};
}

/// Returns the greatest component of |a − b|.
template <class V>
KAGERO_INLINE V greatest_difference(const Vec3<V>& a, const Vec3<V>& b) {
    return max(max(abs(a.x - b.x), abs(a.y - b.y)), abs(a.z - b.z));
}
/// Returns a in the lanes of m, else b.
template <class V>
KAGERO_INLINE Vec3<V> select(const MaskOf<V>& m, const Vec3<V>& a, const Vec3<V>& b) {
    return {select(m, a.x, b.x), select(m, a.y, b.y), select(m, a.z, b.z)};
}
/// Returns a + s·b.
template <class V>
KAGERO_INLINE Vec3<V> advance(const Vec3<V>& a, const V& s, const Vec3<V>& b) {
    return {fma(s, b.x, a.x), fma(s, b.y, a.y), fma(s, b.z, a.z)};
}
/// Returns a − s·b.
template <class V>
KAGERO_INLINE Vec3<V> retreat(const Vec3<V>& a, const V& s, const Vec3<V>& b) {
    return {fnma(s, b.x, a.x), fnma(s, b.y, a.y), fnma(s, b.z, a.z)};
}

}  // namespace kagero

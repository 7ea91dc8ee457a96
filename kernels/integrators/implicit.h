/// Convergence of the iterations for implicit stages, lane by lane. The solution in a converged lane no longer changes
/// while other lanes iterate. The result of a ray therefore does not depend on the other lanes.
#pragma once

#include "kernels/integrators/stepper_state.h"

namespace kagero {

/// Convergence test of one implicit solve.
template <class V>
class Convergence {
    using S = ScalarOf<V>;

public:
    static constexpr int max_iterations = 60;

    /// Initialises the test. Changes of q are measured relative to |q|₁ + |h dq/dτ|₁ at the start of the step, and
    /// changes of p relative to |p|₁ there.
    template <int N>
    KAGERO_INLINE explicit Convergence(const StepperState<V, N>& step)
        : Convergence(step.start, step.h, step.start.velocity, step.options.solver_tolerance) {}
    KAGERO_INLINE Convergence(const State<V>& start, const V& h, const Vec3<V>& velocity, S tolerance)
        : tolerance_(max(tolerance, epsilon)),
          inverse_q_(inverse_of(fma(abs(h), norm1(velocity), norm1(start.q())))),
          inverse_p_(inverse_of(norm1(start.p()))),
          unconverged_(all_lanes<V>()),
          previous_(V(S(0))) {}

    /// Returns the lanes that have not converged.
    KAGERO_INLINE const MaskOf<V>& unconverged() const { return unconverged_; }
    /// Returns the relative size of a change of q and p. The arguments are the greatest components of both changes.
    KAGERO_INLINE V relative(const V& change_q, const V& change_p) const {
        return max(change_q * inverse_q_, change_p * inverse_p_);
    }
    /// Returns the relative size of a change of q alone.
    KAGERO_INLINE V relative_q(const V& change_q) const { return change_q * inverse_q_; }
    /// Returns the relative size of a change of p alone.
    KAGERO_INLINE V relative_p(const V& change_p) const { return change_p * inverse_p_; }

    /// Updates the test with the relative change of this iteration. The iteration contracts linearly, by the factor
    /// change/previous, where `previous` is the change of the iteration before. The next change would thus be about
    /// change²/previous. A lane also converges if the change is at the level of rounding and no longer halves.
    KAGERO_INLINE void update(const V& change) {
        // A lane converges if this change or the estimated next change is below the tolerance: change² ≤ tolerance ·
        // max(change, previous).
        mark_converged(change * change <= V(tolerance_) * max(change, previous_), change);
    }
    /// Updates the test, if the test is applied only to every second iteration. change/previous is then the square of
    /// the contraction factor, and the next change is about √(change³/previous).
    KAGERO_INLINE void update_every_second(const V& change) {
        mark_converged(change * change * change <= V(tolerance_ * tolerance_) * max(change, previous_), change);
    }
    /// Updates the test of Newton's method, which converges quadratically: the next change is about change².
    KAGERO_INLINE void update_quadratic(const V& change) {
        mark_converged(change * change <= V(tolerance_), change);
    }

    /// Returns the lanes in which a change is so small that it may consist of rounding errors alone.
    KAGERO_INLINE MaskOf<V> may_be_rounding(const V& change) const { return change <= V(S(64) * epsilon); }

    /// Marks lanes as not converged, because their solution may be the wrong one.
    KAGERO_INLINE void mark_unconverged(const MaskOf<V>& lanes) { unconverged_ = unconverged_ | lanes; }

private:
    static constexpr S epsilon = machine_epsilon<S>;
    /// Marks lanes as converged: those of `below_tolerance`, and those whose change may consist of rounding errors and
    /// is at least half of the previous change.
    KAGERO_INLINE void mark_converged(const MaskOf<V>& below_tolerance, const V& change) {
        const MaskOf<V> at_rounding = may_be_rounding(change) & (previous_ <= change + change);
        const MaskOf<V> moderate = change <= V(S(1));  // false for changes that are infinite or NaN
        unconverged_ = unconverged_ & !((below_tolerance | at_rounding) & moderate);
        previous_ = change;
    }
    /// Returns |a|₁.
    KAGERO_INLINE static V norm1(const Vec3<V>& a) { return abs(a.x) + abs(a.y) + abs(a.z); }
    /// Returns 1/a; the result is finite for a = 0.
    KAGERO_INLINE static V inverse_of(const V& a) { return recip(max(a, V(S(std::numeric_limits<float>::min())))); }

    S tolerance_;
    V inverse_q_, inverse_p_;
    MaskOf<V> unconverged_;
    V previous_;
};

/// Returns the state with position q, momentum p, and p_t of the start of the step.
template <class V, int N>
KAGERO_INLINE State<V> make_state(const StepperState<V, N>& step, const Vec3<V>& q, const Vec3<V>& p) {
    return {{q.x, q.y, q.z, p.x, p.y, p.z, step.start.pt()}};
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

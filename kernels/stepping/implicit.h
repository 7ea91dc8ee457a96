/// Convergence of fixed-point iterations, lane by lane. A lane that has converged is frozen while others go on, so that no ray's
/// result depends on its neighbours.
#pragma once

#include "kernels/stepping/flow.h"

namespace kagero {

template <class V>
class Convergence {
    using S = ScalarOf<V>;

public:
    static constexpr int max_iterations = 60;

    /// Changes are measured relative to |q|₁ + |h dq/dτ|₁ and |p|₁ at the start of the step.
    KAGERO_INLINE explicit Convergence(const Flow<V>& f)
        : tolerance_(max(f.solver_tolerance, epsilon)),
          inverse_q_(inverse_size(mul_add(abs(f.h), size(f.start_velocity), size(f.start.q())))),
          inverse_p_(inverse_size(size(f.start.p()))),
          open_(V(S(0)) <= V(S(0))),
          previous_(V(S(0))) {}

    /// Lanes that still iterate.
    KAGERO_INLINE const MaskOf<V>& open() const { return open_; }
    /// Relative size of a change of q by dq and of p by dp (greatest components).
    KAGERO_INLINE V relative(const V& dq, const V& dp) const { return max(dq * inverse_q_, dp * inverse_p_); }
    KAGERO_INLINE V relative_q(const V& dq) const { return dq * inverse_q_; }
    KAGERO_INLINE V relative_p(const V& dp) const { return dp * inverse_p_; }

    /// Takes the relative change of this iteration. Iterations contract linearly: the change that would come next is about
    /// change²/previous. At the level of rounding a change that shrinks no more is accepted as well.
    KAGERO_INLINE void update(const V& change) {
        const V tolerance(tolerance_), rounding(S(64) * epsilon);
        // change² ≤ tolerance · max(change, previous): small enough now, or next time.
        const MaskOf<V> done = (change * change <= tolerance * max(change, previous_)) |
                               ((change <= rounding) & (previous_ <= change + change));
        open_ = open_ & !(done & (change <= V(S(1))));  // infinite changes satisfy the first as well
        previous_ = change;
    }

    /// Lanes whose solution is not to be trusted count as not converged.
    KAGERO_INLINE void reopen(const MaskOf<V>& lanes) { open_ = open_ | lanes; }
    /// The same where iterations converge quadratically (Newton): the next change is about the square of this one.
    void update_quadratic(const V& change) {
        const V tolerance(tolerance_), rounding(S(64) * epsilon);
        const MaskOf<V> done = (change * change <= tolerance) | ((change <= rounding) & (previous_ <= change + change));
        open_ = open_ & !done;
        previous_ = change;
    }

private:
    static constexpr S epsilon = machine_epsilon<S>;
    KAGERO_INLINE static V size(const Vec3<V>& a) { return abs(a.x) + abs(a.y) + abs(a.z); }
    KAGERO_INLINE static V inverse_size(const V& a) { return recip(max(a, V(S(std::numeric_limits<float>::min())))); }

    S tolerance_;
    V inverse_q_, inverse_p_;
    MaskOf<V> open_;
    V previous_;
};

/// Greatest component of |a − b|.
template <class V>
KAGERO_INLINE V greatest_difference(const Vec3<V>& a, const Vec3<V>& b) {
    return max(max(abs(a.x - b.x), abs(a.y - b.y)), abs(a.z - b.z));
}
template <class V>
KAGERO_INLINE Vec3<V> pick(const MaskOf<V>& m, const Vec3<V>& a, const Vec3<V>& b) {
    return {pick(m, a.x, b.x), pick(m, a.y, b.y), pick(m, a.z, b.z)};
}
/// a + s·b.
template <class V>
KAGERO_INLINE Vec3<V> advance(const Vec3<V>& a, const V& s, const Vec3<V>& b) {
    return {mul_add(s, b.x, a.x), mul_add(s, b.y, a.y), mul_add(s, b.z, a.z)};
}
/// a − s·b.
template <class V>
KAGERO_INLINE Vec3<V> retreat(const Vec3<V>& a, const V& s, const Vec3<V>& b) {
    return {neg_mul_add(s, b.x, a.x), neg_mul_add(s, b.y, a.y), neg_mul_add(s, b.z, a.z)};
}
/// Number of lanes that hold.
template <class M>
KAGERO_INLINE std::uint64_t count(const M& m) { return static_cast<std::uint64_t>(__builtin_popcountll(to_bits(m))); }

}  // namespace kagero

/// Dense output of one step as a Bézier curve. It is the cubic Hermite curve for positions and velocities at both ends,
/// or the collocation polynomial of a method with more than three stages.
#pragma once

#include "kernels/integrators/gauss_table.h"
#include "kernels/integrators/implicit.h"

namespace kagero {

/// Returns √x with an error of a few roundings; 0 at x = 0. On AVX-512 the slow square-root instruction is avoided.
template <class V>
KAGERO_INLINE V fast_sqrt(const V& x) {
#if defined(__AVX512F__)
    return x * rsqrt(max(x, V(std::numeric_limits<ScalarOf<V>>::min())));
#else
    return sqrt(x);
#endif
}

/// An axis-aligned box: the minimum and the maximum of each coordinate.
template <class V>
struct Extent {
    Vec3<V> lower, upper;

    KAGERO_INLINE static Extent of(const Vec3<V>& q) { return {q, q}; }
    KAGERO_INLINE void include(const Vec3<V>& q) {
        lower = {min(lower.x, q.x), min(lower.y, q.y), min(lower.z, q.z)};
        upper = {max(upper.x, q.x), max(upper.y, q.y), max(upper.z, q.z)};
    }
};

/// A Bézier curve of degree `degree` in position space; its parameter s is the fraction of the step, 0 ≤ s ≤ 1.
template <class V>
class Curve {
    using S = ScalarOf<V>;

public:
    static constexpr int max_degree = max_stages;
    int degree;
    Vec3<V> point[max_degree + 1];  ///< control points; the curve lies within their convex hull

    /// Returns the cubic Hermite curve of a step; its error is O(h⁴).
    template <int N>
    KAGERO_INLINE static Curve hermite(const Step<V, N>& step) {
        const V third = step.h * V(S(1) / S(3));
        Curve c;
        c.degree = 3;
        c.point[0] = step.start.q();
        c.point[1] = advance(step.start.q(), third, step.start.velocity);
        c.point[2] = retreat(step.end.q(), third, step.end.velocity);
        c.point[3] = step.end.q();
        return c;
    }
    /// Returns the collocation polynomial of degree s of a method with s stages (Hairer, Lubich & Wanner 2006,
    /// §II.1.2). Its error is O(h^{s+1}). `velocity(j)` returns dq/dτ at stage j.
    template <int N, class Velocity>
    static Curve collocation(const Step<V, N>& step, const GaussNumbers<S>& w, int s, const Velocity& velocity) {
        Curve c;
        c.degree = s;
        c.point[0] = step.start.q();
        c.point[s] = step.end.q();
        for (int i = 1; i < s; ++i) {
            Vec3<V> sum = V(w.control[i - 1][0]) * velocity(0);
            for (int j = 1; j < s; ++j) sum = advance(sum, V(w.control[i - 1][j]), velocity(j));
            c.point[i] = advance(step.start.q(), step.h, sum);
        }
        return c;
    }

    /// Returns the position at the fraction s of the step; exact at 0 and 1.
    KAGERO_INLINE Vec3<V> at(const V& s) const {
        const auto points = [this](int i) __attribute__((always_inline)) { return point[i]; };
        return degree == 3 ? evaluate(3, s, points) : evaluate(degree, s, points);
    }
    /// Returns the position at s = ½.
    KAGERO_INLINE Vec3<V> middle() const {
        if (degree != 3) return at(V(S(0.5)));
        return V(S(0.125)) * (point[0] + point[3]) + V(S(0.375)) * (point[1] + point[2]);
    }
    /// Returns the derivative dq/ds at s.
    KAGERO_INLINE Vec3<V> slope(const V& s) const {
        const auto differences = [this](int i) __attribute__((always_inline)) { return point[i + 1] - point[i]; };
        return V(S(degree)) * (degree == 3 ? evaluate(2, s, differences) : evaluate(degree - 1, s, differences));
    }
    /// Returns an upper bound of the distance between the curve C and its chord. If the curve is halved, the bounds of
    /// the halves are at most a quarter of this bound. The bound is max |C″|/8 (Filip, Magedson & Markot 1986), where
    /// C″ is bounded by the second differences of the control points. This is a bound on the distance at equal s, and
    /// it is therefore also valid for a curve that turns back and extends beyond the ends of its chord. If the curve
    /// advances monotonically along the chord, only the distance perpendicular to the chord is bounded: by the second
    /// differences across the chord, plus the slope relative to the chord times the second differences along the chord.
    V sagitta() const {
        constexpr S smallest_normal = std::numeric_limits<float>::min();
        const Vec3<V> chord = point[degree] - point[0];
        const V chord2 = dot(chord, chord), inverse = recip(max(chord2, V(smallest_normal)));
        V along_before, slope2(S(0));  // slope2: square of the greatest slope relative to the chord
        // Squares of the greatest second differences: along the chord, across the chord, and of the whole vector.
        V along2(S(0)), across2(S(0)), whole2(S(0));
        Vec3<V> edge_before, across_before;
        MaskOf<V> forward = all_lanes<V>();
        for (int i = 0; i < degree; ++i) {
            const Vec3<V> edge = point[i + 1] - point[i];
            const V along = dot(edge, chord) * inverse;
            const Vec3<V> across = retreat(edge, along, chord);
            forward = forward & (along > V(S(0)));
            slope2 = max(slope2, dot(across, across) / max(along * along * chord2, V(smallest_normal)));
            if (i > 0) {
                const Vec3<V> second = edge - edge_before, second_across = across - across_before;
                const V second_along = along - along_before;
                whole2 = max(whole2, dot(second, second));
                across2 = max(across2, dot(second_across, second_across));
                along2 = max(along2, second_along * second_along * chord2);
            }
            edge_before = edge;
            across_before = across;
            along_before = along;
        }
        const V monotonic = fast_sqrt(across2) + fast_sqrt(slope2 * along2);
        return V(S(degree * (degree - 1) / 8.0)) * select(forward, monotonic, fast_sqrt(whole2));
    }
    /// Returns an upper bound of the squared distance of the curve from the origin, computed from its control
    /// points.
    V max_radius2() const {
        V square(S(0));
        for (int i = 0; i <= degree; ++i) square = max(square, dot(point[i], point[i]));
        return square;
    }
    /// Returns a box that contains the curve: the bounding box of its control points.
    KAGERO_INLINE Extent<V> extent() const {
        Extent<V> extent = Extent<V>::of(point[0]);
        if (degree == 3) {
            extent.include(point[1]);
            extent.include(point[2]);
            extent.include(point[3]);
        } else for (int i = 1; i <= degree; ++i) extent.include(point[i]);
        return extent;
    }
    /// Returns a box that contains dq/ds for all s, from the differences of the control points.
    Extent<V> slope_extent() const {
        Extent<V> slope_extent = Extent<V>::of(point[1] - point[0]);
        for (int i = 1; i < degree; ++i) slope_extent.include(point[i + 1] - point[i]);
        return {V(S(degree)) * slope_extent.lower, V(S(degree)) * slope_extent.upper};
    }

private:
    /// Returns Σ_i binomial(n, i) (1 − s)^{n−i} s^i points(i), evaluated by a Horner scheme.
    template <class Point>
    KAGERO_INLINE static Vec3<V> evaluate(int n, const V& s, const Point& points) {
        const V t = V(S(1)) - s;
        V power(S(1));
        int binomial = 1;
        Vec3<V> sum = points(0);
        for (int i = 1; i <= n; ++i) {
            power = power * s;
            binomial = binomial * (n - i + 1) / i;
            sum = advance(t * sum, V(S(binomial)) * power, points(i));
        }
        return sum;
    }
};

}  // namespace kagero

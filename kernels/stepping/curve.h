/// Dense output of one step: a Bézier curve. The cubic Hermite curve through both ends with both velocities, or, where a method has
/// one of higher order, its own.
#pragma once

#include "kernels/stepping/gauss_table.h"
#include "kernels/stepping/implicit.h"

namespace kagero {

/// √x to a few roundings, without the slow instruction where there is another; 0 at 0.
template <class V>
KAGERO_INLINE V root(const V& x) {
#if defined(__AVX512F__)
    return x * rsqrt(max(x, V(std::numeric_limits<ScalarOf<V>>::min())));
#else
    return sqrt(x);
#endif
}

/// The least and the greatest of each coordinate.
template <class V>
struct Extent {
    Vec3<V> lower, upper;

    KAGERO_INLINE static Extent of(const Vec3<V>& q) { return {q, q}; }
    KAGERO_INLINE void include(const Vec3<V>& q) {
        lower = {min(lower.x, q.x), min(lower.y, q.y), min(lower.z, q.z)};
        upper = {max(upper.x, q.x), max(upper.y, q.y), max(upper.z, q.z)};
    }
};

template <class V>
class Curve {
    using S = ScalarOf<V>;

public:
    static constexpr int most = max_stages;
    int degree;
    Vec3<V> point[most + 1];  ///< control points: the curve is within their convex hull

    /// The error is O(h⁴).
    KAGERO_INLINE static Curve hermite(const Leg<V>& f) {
        const V third = f.h * V(S(1) / S(3));
        Curve c;
        c.degree = 3;
        c.point[0] = f.start.q(), c.point[1] = advance(f.start.q(), third, f.start.velocity);
        c.point[2] = retreat(f.end.q(), third, f.end.velocity), c.point[3] = f.end.q();
        return c;
    }
    /// The polynomial of degree s that collocation with s stages is, with an error O(h^{s+1}) (Hairer, Lubich & Wanner 2006,
    /// §II.1.2); `velocity(j)` is dq/dτ at stage j.
    template <class Velocity>
    static Curve collocation(const Leg<V>& f, const GaussNumbers<S>& w, int s, const Velocity& velocity) {
        Curve c;
        c.degree = s;
        c.point[0] = f.start.q(), c.point[s] = f.end.q();
        for (int i = 1; i < s; ++i) {
            Vec3<V> way = V(w.control[i - 1][0]) * velocity(0);
            for (int j = 1; j < s; ++j) way = advance(way, V(w.control[i - 1][j]), velocity(j));
            c.point[i] = advance(f.start.q(), f.h, way);
        }
        return c;
    }

    /// At the fraction s of the step; exact at 0 and 1.
    KAGERO_INLINE Vec3<V> at(const V& s) const {
        const auto points = [this](int i) __attribute__((always_inline)) { return point[i]; };
        return degree == 3 ? evaluate(3, s, points) : evaluate(degree, s, points);
    }
    KAGERO_INLINE Vec3<V> middle() const {
        if (degree != 3) return at(V(S(0.5)));
        return V(S(0.125)) * (point[0] + point[3]) + V(S(0.375)) * (point[1] + point[2]);
    }
    /// d/ds.
    KAGERO_INLINE Vec3<V> slope(const V& s) const {
        const auto ways = [this](int i) __attribute__((always_inline)) { return point[i + 1] - point[i]; };
        return V(S(degree)) * (degree == 3 ? evaluate(2, s, ways) : evaluate(degree - 1, s, ways));
    }
    /// An upper bound of the distance between curve and chord, with a tenth to spare: that of the inner control points from it, times
    /// the most that they together weigh, 1 − 2^{1−degree}.
    KAGERO_INLINE V sagitta() const {
        const Vec3<V> chord = point[degree] - point[0];
        const V inverse = recip(max(dot(chord, chord), V(S(std::numeric_limits<float>::min()))));
        V off(S(0));
        for (int i = 1; i < degree; ++i) {
            const Vec3<V> e = point[i] - point[0];
            const V along = dot(e, chord);
            off = max(off, dot(e, e) - along * along * inverse);
        }
        return V(S(1.1 * (1 - 2.0 / (1 << degree)))) * root(off);
    }
    /// Square of the greatest distance of any point of the curve from the origin; bounded by its control points.
    V reach2() const {
        V square(S(0));
        for (int i = 0; i <= degree; ++i) square = max(square, dot(point[i], point[i]));
        return square;
    }
    /// Of all points of the curve; bounded by its control points.
    KAGERO_INLINE Extent<V> extent() const {
        Extent<V> extent = Extent<V>::of(point[0]);
        if (degree == 3) extent.include(point[1]), extent.include(point[2]), extent.include(point[3]);
        else for (int i = 1; i <= degree; ++i) extent.include(point[i]);
        return extent;
    }
    /// The same of d/ds; bounded by the ways between its control points.
    Extent<V> speeds() const {
        Extent<V> speeds = Extent<V>::of(point[1] - point[0]);
        for (int i = 1; i < degree; ++i) speeds.include(point[i + 1] - point[i]);
        return {V(S(degree)) * speeds.lower, V(S(degree)) * speeds.upper};
    }

private:
    /// Σ binomial(n, i) (1 − s)^{n−i} s^i point(i), as Horner would.
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

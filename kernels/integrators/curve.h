/// Dense output of one step: a Bézier curve. The cubic Hermite curve through both ends with both velocities, or, where
/// a method has one of higher order, its own.
#pragma once

#include "kernels/integrators/gauss_table.h"
#include "kernels/integrators/implicit.h"

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
    template <int N>
    KAGERO_INLINE static Curve hermite(const Step<V, N>& f) {
        const V third = f.h * V(S(1) / S(3));
        Curve c;
        c.degree = 3;
        c.point[0] = f.start.q(), c.point[1] = advance(f.start.q(), third, f.start.velocity);
        c.point[2] = retreat(f.end.q(), third, f.end.velocity), c.point[3] = f.end.q();
        return c;
    }
    /// The polynomial of degree s that collocation with s stages is, with an error O(h^{s+1}) (Hairer, Lubich & Wanner
    /// 2006, §II.1.2); `velocity(j)` is dq/dτ at stage j.
    template <int N, class Velocity>
    static Curve collocation(const Step<V, N>& f, const GaussNumbers<S>& w, int s, const Velocity& velocity) {
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
    /// An upper bound of the distance between the curve and its chord, of which halves have at most a quarter: max
    /// |C″|/8 (Filip, Magedson & Markot 1986), by the second differences of the control points. It is one of the
    /// distance between places at the same s, and so holds beyond the ends of the chord as well, where a ray turns
    /// back. A curve that goes forward along its chord, however unevenly, is off by what it does across, and by its
    /// slope there times what it does along.
    V sagitta() const {
        constexpr S least = std::numeric_limits<float>::min();
        const Vec3<V> chord = point[degree] - point[0];
        const V square = dot(chord, chord), inverse = recip(max(square, V(least)));
        V along_before, slope2(S(0)), along2(S(0)), across2(S(0)), whole2(S(0));
        Vec3<V> way_before, across_before;
        MaskOf<V> forward = always<V>();
        for (int i = 0; i < degree; ++i) {
            const Vec3<V> way = point[i + 1] - point[i];
            const V along = dot(way, chord) * inverse;
            const Vec3<V> across = retreat(way, along, chord);
            forward = forward & (along > V(S(0)));
            slope2 = max(slope2, dot(across, across) / max(along * along * square, V(least)));
            if (i > 0) {
                const Vec3<V> turn = way - way_before, turn_across = across - across_before;
                const V turn_along = along - along_before;
                whole2 = max(whole2, dot(turn, turn)), across2 = max(across2, dot(turn_across, turn_across));
                along2 = max(along2, turn_along * turn_along * square);
            }
            way_before = way, across_before = across, along_before = along;
        }
        return V(S(degree * (degree - 1) / 8.0)) * select(forward, root(across2) + root(slope2 * along2), root(whole2));
    }
    /// Square of the greatest distance of any point of the curve from the origin; bounded by its control points.
    V reach2() const {
        V square(S(0));
        for (int i = 0; i <= degree; ++i) square = max(square, dot(point[i], point[i]));
        return square;
    }
    /// A box that contains the curve: that of its control points.
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

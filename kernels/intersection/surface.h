/// Surfaces as the zeros of one function, for refining where a curve meets them.
#pragma once

#include "kernels/abi.h"
#include "kernels/integrators/implicit.h"


namespace kagero {

/// g(q) = a (|q − c|² − R²) + n·q − d: a plane (a = 0, |n| = 1) or a sphere (a = 1/2R, n = 0), so that |∇g| = 1 on the
/// surface.
template <class V>
struct Level {
    V a, radius2;
    Vec3<V> center, normal;
    V d;
    bool curved;  ///< not all lanes have planes

    /// No surface at all.
    static Level none() {
        const V zero(ScalarOf<V>(0));
        return {zero, zero, {zero, zero, zero}, {zero, zero, zero}, zero, false};
    }
    KAGERO_INLINE V value(const Vec3<V>& q) const {
        const V above = dot(normal, q) - d;
        if (!curved) return above;
        const Vec3<V> e = q - center;
        return a * (dot(e, e) - radius2) + above;
    }
    /// dg along v.
    KAGERO_INLINE V slope(const Vec3<V>& q, const Vec3<V>& v) const {
        const V along = dot(normal, v);
        return curved ? (a + a) * dot(q - center, v) + along : along;
    }

    /// The distance along v, in lengths of v, from q to the zero of g. On a sphere `falling` chooses the side: where g
    /// falls or where it rises. If the line misses the sphere, `misses` is set, and `length` leads to the point of the
    /// line that is nearest to it.
    struct Way {
        V length;
        MaskOf<V> misses;
    };
    KAGERO_INLINE Way way(const Vec3<V>& q, const Vec3<V>& v, const MaskOf<V>& falling) const {
        const V zero(ScalarOf<V>(0)), plane = (d - dot(normal, q)) / dot(normal, v);
        if (!curved) return {plane, never<V>()};
        const MaskOf<V> round = abs(a) > zero;
        const Vec3<V> e = q - center;
        const V inverse = recip(dot(v, v)), middle = -dot(e, v) * inverse;
        const Vec3<V> nearest = advance(e, middle, v);
        const V half2 = (radius2 - dot(nearest, nearest)) * inverse, half = sqrt(max(half2, zero));
        return {select(round, middle + select(falling, -half, half), plane), MaskOf<V>(round & (half2 < zero))};
    }

    /// `set(number, other)` for each number of two levels.
    template <class Other, class F>
    static void each(Level& level, const Level<Other>& other, const F& set) {
        set(level.a, other.a), set(level.radius2, other.radius2), set(level.d, other.d);
        set(level.center.x, other.center.x), set(level.center.y, other.center.y), set(level.center.z, other.center.z);
        set(level.normal.x, other.normal.x), set(level.normal.y, other.normal.y), set(level.normal.z, other.normal.z);
    }
    void take(const MaskOf<V>& lanes, const Level& from) {
        each(*this, from, [&lanes](V& number, const V& other) { number = select(lanes, other, number); });
        curved |= from.curved;
    }
};

/// The sphere around the origin.
template <class V>
Level<V> sphere_level(const V& radius) {
    const V zero(ScalarOf<V>(0));
    return {V(ScalarOf<V>(0.5)) / radius, radius * radius, {zero, zero, zero}, {zero, zero, zero}, zero, true};
}

/// The plane of one triangle, or a sphere.
inline Level<double> level_of(const Surface& surface, std::uint32_t primitive) {
    if (surface.kind == Surface::Kind::sphere) {
        const double* c = surface.center;
        return {0.5 / surface.radius, surface.radius * surface.radius, {c[0], c[1], c[2]}, {0, 0, 0}, 0, true};
    }
    const double* plane = surface.planes + 4 * std::size_t(primitive);
    return {0, 0, {0, 0, 0}, {plane[0], plane[1], plane[2]}, plane[3], false};
}

/// What the lanes of `lanes` met, each its own surface, where they are not all on the same. Other lanes have any.
template <class V, int W = lane_count<V>>
Level<V> levels_of(const Surface* surfaces, const std::uint32_t (&surface)[W], const std::uint32_t (&primitive)[W],
                   std::uint64_t lanes) {
    using S = ScalarOf<V>;
    const int first = __builtin_ctzll(lanes);
    std::uint32_t others = 0;
    for (int i = 0; i < W; ++i) others |= (surface[i] ^ surface[first]) | (primitive[i] ^ primitive[first]);
    const Level<double> g = level_of(surfaces[surface[first]], primitive[first]);
    Level<V> levels;
    Level<V>::each(levels, g, [](V& number, double on_all) { number = V(S(on_all)); });
    levels.curved = g.curved;
    for (const int i : lanes_in(others ? lanes : 0)) {
        if (surface[i] == surface[first] && primitive[i] == primitive[first]) continue;
        const Level<double> other = level_of(surfaces[surface[i]], primitive[i]);
        Level<V>::each(levels, other, [i](V& number, double here) { set_lane(number, i, S(here)); });
        levels.curved |= other.curved;
    }
    return levels;
}

/// Where the straight segment a → b meets the surface, as a fraction; the root nearest to `near`, which Embree found in
/// float. Refinement starts here, so that no result depends on how Embree was asked.
template <class V>
V chord_fraction(const Level<V>& g, const Vec3<V>& a, const Vec3<V>& b, const V& near) {
    const V zero(ScalarOf<V>(0));
    const Vec3<V> d = b - a;
    const V linear = dot(g.normal, d), on_plane = select(abs(linear) > zero, -g.value(a) / linear, near);
    if (!g.curved) return on_plane;
    // From the point nearest to the centre, so that nothing cancels for a segment that comes from far away.
    const Vec3<V> e = a - g.center;
    const V length2 = dot(d, d), middle = -dot(e, d) / length2;
    const Vec3<V> nearest = advance(e, middle, d);
    const V half2 = (g.radius2 - dot(nearest, nearest)) / length2, half = sqrt(max(half2, zero));
    const V first = middle - half, second = middle + half;
    const V on_sphere = select(half2 >= zero, select(abs(first - near) < abs(second - near), first, second), near);
    return select(abs(g.a) > zero, on_sphere, on_plane);
}

}  // namespace kagero

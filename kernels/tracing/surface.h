/// Surfaces as the zeros of one function, for refining where a curve meets them.
#pragma once

#include "kernels/abi.h"
#include "kernels/stepping/implicit.h"

#include <cmath>

namespace kagero {

/// g(q) = a (|q − c|² − R²) + n·q − d: a plane (a = 0, |n| = 1) or a sphere (a = 1/2R, n = 0), so that |∇g| = 1 on the surface.
template <class V>
struct Level {
    V a, radius2;
    Vec3<V> center, normal;
    V d;

    /// No surface at all.
    static Level none() {
        const V zero(ScalarOf<V>(0));
        return {zero, zero, {zero, zero, zero}, {zero, zero, zero}, zero};
    }
    KAGERO_INLINE V value(const Vec3<V>& q) const {
        const Vec3<V> e = q - center;
        return a * (dot(e, e) - radius2) + (dot(normal, q) - d);
    }
    /// dg along v.
    KAGERO_INLINE V slope(const Vec3<V>& q, const Vec3<V>& v) const { return (a + a) * dot(q - center, v) + dot(normal, v); }

    void take(const MaskOf<V>& lanes, const Level& from) {
        a = pick(lanes, from.a, a), radius2 = pick(lanes, from.radius2, radius2), d = pick(lanes, from.d, d);
        center = pick<V>(lanes, from.center, center), normal = pick<V>(lanes, from.normal, normal);
    }
};

/// The sphere around the origin.
template <class V>
Level<V> sphere_level(const V& radius) {
    const V zero(ScalarOf<V>(0));
    return {V(ScalarOf<V>(0.5)) / radius, radius * radius, {zero, zero, zero}, {zero, zero, zero}, zero};
}

/// What the lanes of `lanes` met, each its own surface: the plane of a triangle, or a sphere.
template <class V>
Level<V> levels_of(const Surface* surfaces, const std::uint32_t* surface, const std::uint32_t* primitive, std::uint64_t lanes) {
    constexpr int W = lane_count<V>;
    static constexpr double nothing[4] = {};
    alignas(64) double a[W], radius2[W], center[3][W], plane[4][W];
    for (int i = 0; i < W; ++i) {
        const Surface* s = (lanes >> i) & 1 ? surfaces + surface[i] : nullptr;
        const bool ball = s && s->kind == Surface::Kind::sphere;
        const double *c = ball ? s->center : nothing, *n = s && !ball ? s->planes + 4 * std::size_t(primitive[i]) : nothing;
        a[i] = ball ? 0.5 / s->radius : 0, radius2[i] = ball ? s->radius * s->radius : 0;
        for (int k = 0; k < 3; ++k) center[k][i] = c[k];
        for (int k = 0; k < 4; ++k) plane[k][i] = n[k];
    }
    return {lanes_of<V>(a), lanes_of<V>(radius2), {lanes_of<V>(center[0]), lanes_of<V>(center[1]), lanes_of<V>(center[2])},
            {lanes_of<V>(plane[0]), lanes_of<V>(plane[1]), lanes_of<V>(plane[2])}, lanes_of<V>(plane[3])};
}

/// Where the straight segment a → b meets the surface, as a fraction; the root nearest to `near`, which Embree found in float. Refinement
/// starts here, so that no result depends on how Embree was asked.
template <class V>
V chord_fraction(const Level<V>& g, const Vec3<V>& a, const Vec3<V>& b, const V& near) {
    const V zero(ScalarOf<V>(0));
    const Vec3<V> d = b - a;
    const V linear = dot(g.normal, d), on_plane = pick(abs(linear) > zero, -g.value(a) / linear, near);
    const MaskOf<V> flat = abs(g.a) <= zero;
    if (!any(!flat)) return on_plane;
    // From the point nearest to the centre, so that nothing cancels for a segment that comes from far away.
    const Vec3<V> e = a - g.center;
    const V length2 = dot(d, d), middle = -dot(e, d) / length2;
    const Vec3<V> nearest = advance(e, middle, d);
    const V half2 = (g.radius2 - dot(nearest, nearest)) / length2, half = sqrt(max(half2, zero));
    const V first = middle - half, second = middle + half;
    const V on_sphere = pick(half2 >= zero, pick(abs(first - near) < abs(second - near), first, second), near);
    return pick(flat, on_plane, on_sphere);
}

}  // namespace kagero

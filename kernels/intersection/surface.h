/// Planes and spheres as level sets, for the refinement of hits and escapes.
#pragma once

#include "kernels/abi.h"
#include "kernels/integrators/implicit.h"

namespace kagero {

/// One surface for each lane, as the zero set of g(q) = a (|q − c|² − R²) + n·q − d. A plane has a = 0 and |n| = 1; a
/// sphere has a = 1/(2R) and n = 0. On the surface, |∇g| = 1.
template <class V>
struct LevelSet {
    V a, radius2;
    Vec3<V> center, normal;
    V d;
    bool curved;  ///< False if all lanes have planes; sphere terms are then skipped.

    /// Returns a level set with g = 0 everywhere, for lanes without a surface.
    static LevelSet none() {
        const V zero(ScalarOf<V>(0));
        return {zero, zero, {zero, zero, zero}, {zero, zero, zero}, zero, false};
    }
    /// Returns g(q).
    KAGERO_INLINE V value(const Vec3<V>& q) const {
        const V plane_value = dot(normal, q) - d;
        if (!curved) return plane_value;
        const Vec3<V> e = q - center;
        return a * (dot(e, e) - radius2) + plane_value;
    }
    /// Returns the derivative of g at q along v, v·∇g.
    KAGERO_INLINE V slope(const Vec3<V>& q, const Vec3<V>& v) const {
        const V plane_slope = dot(normal, v);
        return curved ? (a + a) * dot(q - center, v) + plane_slope : plane_slope;
    }

    /// Intersection of the line q + s·v with a level set.
    struct LineIntersection {
        V line_parameter;  ///< The value of s at the intersection.
        MaskOf<V> misses;  ///< Lanes whose line misses the sphere; s is then that of the point nearest to the centre.
    };
    /// Returns the intersection of the line q + s·v with the surface. For a sphere, lanes of `decreasing` get the
    /// intersection at which g decreases along v (entry), the other lanes the one at which g increases (exit).
    KAGERO_INLINE LineIntersection intersect_line(const Vec3<V>& q, const Vec3<V>& v,
                                                  const MaskOf<V>& decreasing) const {
        const V zero(ScalarOf<V>(0)), plane_parameter = (d - dot(normal, q)) / dot(normal, v);
        if (!curved) return {plane_parameter, no_lanes<V>()};
        const MaskOf<V> is_sphere = abs(a) > zero;
        const Vec3<V> e = q - center;
        const V inverse = recip(dot(v, v)), middle = -dot(e, v) * inverse;
        const Vec3<V> nearest = advance(e, middle, v);
        const V half2 = (radius2 - dot(nearest, nearest)) * inverse, half = sqrt(max(half2, zero));
        return {select(is_sphere, middle + select(decreasing, -half, half), plane_parameter),
                MaskOf<V>(is_sphere & (half2 < zero))};
    }

    /// Calls `set(number, other_number)` for each coefficient of two level sets.
    template <class Other, class F>
    static void for_each_coefficient(LevelSet& one, const LevelSet<Other>& other, const F& set) {
        set(one.a, other.a);
        set(one.radius2, other.radius2);
        set(one.d, other.d);
        set(one.center.x, other.center.x);
        set(one.center.y, other.center.y);
        set(one.center.z, other.center.z);
        set(one.normal.x, other.normal.x);
        set(one.normal.y, other.normal.y);
        set(one.normal.z, other.normal.z);
    }
    /// Copies the surfaces of `lanes` from another level set.
    void assign_lanes(const MaskOf<V>& lanes, const LevelSet& source) {
        for_each_coefficient(*this, source, [&lanes](V& own, const V& other) { own = select(lanes, other, own); });
        curved |= source.curved;
    }
};

/// Returns the sphere of this radius around the origin.
template <class V>
LevelSet<V> sphere_level_set(const V& radius) {
    const V zero(ScalarOf<V>(0));
    return {V(ScalarOf<V>(0.5)) / radius, radius * radius, {zero, zero, zero}, {zero, zero, zero}, zero, true};
}

/// Returns the plane of triangle `primitive` if the surface is a mesh, else the sphere that the surface is.
inline LevelSet<double> level_set_of(const Surface& surface, std::uint32_t primitive) {
    if (surface.kind == Surface::Kind::sphere) {
        const double* c = surface.center;
        return {0.5 / surface.radius, surface.radius * surface.radius, {c[0], c[1], c[2]}, {0, 0, 0}, 0, true};
    }
    const double* plane = surface.planes + 4 * std::size_t(primitive);
    return {0, 0, {0, 0, 0}, {plane[0], plane[1], plane[2]}, plane[3], false};
}

/// Returns the surfaces that `lanes` have hit, one for each lane. Other lanes get the surface of the lowest lane in
/// `lanes`.
template <class V, int W = lane_count<V>>
LevelSet<V> level_sets_of(const Surface* surfaces, const std::uint32_t (&surface)[W],
                          const std::uint32_t (&primitive)[W], std::uint64_t lanes) {
    using S = ScalarOf<V>;
    const int first = __builtin_ctzll(lanes);
    std::uint32_t differences = 0;
    for (int i = 0; i < W; ++i) differences |= (surface[i] ^ surface[first]) | (primitive[i] ^ primitive[first]);
    const LevelSet<double> g = level_set_of(surfaces[surface[first]], primitive[first]);
    LevelSet<V> level_sets;
    LevelSet<V>::for_each_coefficient(level_sets, g, [](V& number, double value) { number = V(S(value)); });
    level_sets.curved = g.curved;
    for (const int i : lanes_in(differences ? lanes : 0)) {
        if (surface[i] == surface[first] && primitive[i] == primitive[first]) continue;
        const LevelSet<double> other = level_set_of(surfaces[surface[i]], primitive[i]);
        LevelSet<V>::for_each_coefficient(level_sets, other,
                                          [i](V& number, double own_number) { set_lane(number, i, S(own_number)); });
        level_sets.curved |= other.curved;
    }
    return level_sets;
}

/// Returns the fraction s at which the line a + s (b − a) meets the surface. If the line meets a sphere twice, the
/// intersection nearest to s = `near` is returned; without an intersection, `near` itself. For a hit, `near` is the
/// fraction that Embree found in float. Refinement starts at the returned fraction, so that no result depends on the
/// rounding of Embree's query.
template <class V>
V chord_fraction(const LevelSet<V>& g, const Vec3<V>& a, const Vec3<V>& b, const V& near) {
    const V zero(ScalarOf<V>(0));
    const Vec3<V> d = b - a;
    const V plane_slope = dot(g.normal, d);
    const V on_plane = select(abs(plane_slope) > zero, -g.value(a) / plane_slope, near);
    if (!g.curved) return on_plane;
    // The intersections are computed from the point of the line that is nearest to the centre. This avoids cancellation
    // if a is far away from the sphere.
    const Vec3<V> e = a - g.center;
    const V length2 = dot(d, d), middle = -dot(e, d) / length2;
    const Vec3<V> nearest = advance(e, middle, d);
    const V half2 = (g.radius2 - dot(nearest, nearest)) / length2, half = sqrt(max(half2, zero));
    const V first = middle - half, second = middle + half;
    const V on_sphere = select(half2 >= zero, select(abs(first - near) < abs(second - near), first, second), near);
    return select(abs(g.a) > zero, on_sphere, on_plane);
}

}  // namespace kagero

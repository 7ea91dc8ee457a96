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

    KAGERO_INLINE V value(const Vec3<V>& q) const {
        const Vec3<V> e = q - center;
        return a * (dot(e, e) - radius2) + (dot(normal, q) - d);
    }
    /// dg along v.
    KAGERO_INLINE V slope(const Vec3<V>& q, const Vec3<V>& v) const { return (a + a) * dot(q - center, v) + dot(normal, v); }
};

inline Level<double> sphere_level(const double (&center)[3], double radius) {
    return {0.5 / radius, radius * radius, {center[0], center[1], center[2]}, {0, 0, 0}, 0};
}

/// The plane of a triangle, or the sphere, of a surface.
inline Level<double> level_of(const Surface& surface, std::uint32_t primitive) {
    if (surface.kind == Surface::Kind::sphere) return sphere_level(surface.center, surface.radius);
    const auto corner = [&](int k) {
        const double* v = surface.vertices + 3 * std::size_t(surface.triangles[3 * std::size_t(primitive) + k]);
        return Vec3<double>{v[0], v[1], v[2]};
    };
    const Vec3<double> a = corner(0), u = corner(1) - a, w = corner(2) - a;
    Vec3<double> n{u.y * w.z - u.z * w.y, u.z * w.x - u.x * w.z, u.x * w.y - u.y * w.x};
    n = (1 / norm(n)) * n;
    return {0, 0, {0, 0, 0}, n, dot(n, a)};
}

/// Where the straight segment a → b meets the surface, as a fraction, in double; the root nearest to `near`, which Embree found in
/// float. Refinement starts here, so that no result depends on how Embree was asked.
inline double chord_fraction(const Level<double>& g, const Vec3<double>& a, const Vec3<double>& b, double near) {
    const Vec3<double> d = b - a;
    if (g.a == 0) {
        const double linear = dot(g.normal, d);
        return linear != 0 ? -g.value(a) / linear : near;
    }
    // From the point nearest to the centre, so that nothing cancels for a segment that comes from far away.
    const Vec3<double> e = a - g.center;
    const double length2 = dot(d, d), middle = -dot(e, d) / length2;
    const Vec3<double> nearest = e + middle * d;
    const double half2 = (g.radius2 - dot(nearest, nearest)) / length2;
    if (!(half2 >= 0)) return near;
    const double half = std::sqrt(half2);
    return std::abs(middle - half - near) < std::abs(middle + half - near) ? middle - half : middle + half;
}

template <class V>
void set_lane(Level<V>& level, int lane, const Level<double>& one) {
    using S = ScalarOf<V>;
    set_lane(level.a, lane, S(one.a)), set_lane(level.radius2, lane, S(one.radius2)), set_lane(level.d, lane, S(one.d));
    set_lane(level.center.x, lane, S(one.center.x)), set_lane(level.center.y, lane, S(one.center.y));
    set_lane(level.center.z, lane, S(one.center.z)), set_lane(level.normal.x, lane, S(one.normal.x));
    set_lane(level.normal.y, lane, S(one.normal.y)), set_lane(level.normal.z, lane, S(one.normal.z));
}

}  // namespace kagero

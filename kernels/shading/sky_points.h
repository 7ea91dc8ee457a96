/// Texture coordinates and filters of points on the sky.
#pragma once

#include "kernels/shading/sky_footprints.h"

namespace kagero::shading {

/// The numbers that describe how an image is averaged over a stripe; see Probes in src/appearance/pyramid.h.
template <class V>
struct StripeProbes {
    V level, count;

    /// `length` and `width` are those of the stripe in texels.
    StripeProbes(const V& length, const V& width) {
        const V zero(0.0), one(1.0), step = max(max(width, length * V(1.0 / 16)), one);
        level = select(step > one, log(step) * V(1.4426950408889634), zero);
        // The greatest integer that is not greater than `parts`.
        const V parts = select(length > step, length / step * V(1 - 1e-9), zero);
        V whole = nearest_integer(parts);
        whole = select(whole > parts, whole - one, whole);
        count = one + whole;
    }
};

/// Computes the points i, i + 1 and so on, one in each lane.
template <class V>
void compute_points(const SkyPoints& points, std::uint32_t i) {
    constexpr double inverse_pi = 0.31830988618379067;
    const auto axis = [](const double(&a)[3]) { return Vec3<V>{V(a[0]), V(a[1]), V(a[2])}; };
    const Vec3<V> zero = axis(points.zero), east = axis(points.east), up = axis(points.up);
    const Vec3<V> direction = load<V>(points.direction, i), major = load<V>(points.major, i),
                  minor = load<V>(points.minor, i);
    const V x = dot(direction, zero), y = dot(direction, east), z = dot(direction, up);
    // At a pole the gradients diverge; the lower bound √ε on the distance from the axis keeps them finite.
    const V from_axis = max(sqrt(fma(x, x, y * y)), V(1.4901161193847656e-8)),
            inverse = V(1.0) / from_axis, across = V(0.5 * inverse_pi) * inverse, along_row = across * inverse;
    to_doubles(fnma(V(0.5 * inverse_pi), atan2(y, x), V(0.5)), points.u + i);
    to_doubles(fma(V(inverse_pi), atan2(z, from_axis), V(0.5)), points.v + i);
    const auto u_difference = [&](const Vec3<V>& side) {
        return along_row * fms(y, dot(side, zero), x * dot(side, east));
    };
    to_doubles(u_difference(major), points.by_major[0] + i);
    if (points.texel > 0) {
        // The stripe of an image is perpendicular to the direction, up to its curvature.
        to_doubles(V(2.0) * across * dot(major, up), points.by_major[1] + i);
        const V inverse_texel(1 / points.texel), square = dot(major, major);
        if (points.level) {
            const StripeProbes<V> probes(sqrt(square) * inverse_texel, norm(minor) * inverse_texel);
            to_doubles(probes.level, points.level + i);
            to_doubles(probes.count, points.probes + i);
        }
        to_doubles(square * V(0.5) * inverse_texel * inverse, points.bend + i);
        return;
    }
    const auto v_difference = [&](const Vec3<V>& side) {
        const V toward_axis = fma(x, dot(side, zero), y * dot(side, east));
        return V(2.0) * across * fms(from_axis * from_axis, dot(side, up), z * toward_axis);
    };
    to_doubles(v_difference(major), points.by_major[1] + i);
    to_doubles(u_difference(minor), points.by_minor[0] + i);
    to_doubles(v_difference(minor), points.by_minor[1] + i);
}

}  // namespace kagero::shading

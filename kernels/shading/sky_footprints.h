/// Footprints of blocks of 2 × 2 rays on the sky.
#pragma once

#include "kernels/numeric/vec.h"
#include "kernels/shading.h"
#include "kernels/simd/lane_memory.h"

namespace kagero::shading {

template <class V>
KAGERO_INLINE Vec3<V> load(const double* const (&components)[3], std::uint32_t i) {
    return {lanes_of<V>(components[0] + i), lanes_of<V>(components[1] + i), lanes_of<V>(components[2] + i)};
}
template <class V>
KAGERO_INLINE void store(const Vec3<V>& v, double* const (&components)[3], std::uint32_t i) {
    to_doubles(v.x, components[0] + i);
    to_doubles(v.y, components[1] + i);
    to_doubles(v.z, components[2] + i);
}

/// Two perpendicular unit vectors that are perpendicular to a direction.
template <class V>
struct TangentAxes {
    Vec3<V> e1, e2;

    /// e1 is the direction of +x, or of ∓z where the pole is ±x.
    explicit TangentAxes(const Vec3<V>& pole) {
        const V zero(0.0), one(1.0), least(1.4901161193847656e-8);  // √ε
        const Vec3<V> up = (one / norm(pole)) * pole;
        const Vec3<V> projected{one - up.x * up.x, zero - up.x * up.y, zero - up.x * up.z};
        const auto is_pole = norm(projected) < least;
        const Vec3<V> axis{select(is_pole, zero, projected.x), select(is_pole, zero, projected.y),
                           select(is_pole, select(up.x > zero, -one, one), projected.z)};
        e1 = (one / norm(axis)) * axis;
        e2 = cross(up, e1);
    }
};

/// Computes the footprints of the blocks i, i + 1 and so on, one in each lane. The four directions are an affine
/// function of the film position, plus a bilinear term, which is orthogonal to it. The sum of the outer products of the
/// three terms is the covariance matrix of the footprint.
template <class V>
void compute_footprints(const SkyBlocks& blocks, std::uint32_t i) {
    const auto direction = [&](int ray) { return load<V>(blocks.directions[ray], i); };
    const Vec3<V> d0 = direction(0), d1 = direction(1), d2 = direction(2), d3 = direction(3);
    const TangentAxes<V> axes((d0 + d1) + (d2 + d3));
    const Vec3<V> falling = d3 - d0, rising = d1 - d2;
    const V zero(0.0), half(0.5), one(1.0);
    V xx = zero, xy = zero, yy = zero;
    for (const Vec3<V>& term : {falling + rising, falling - rising, (d0 + d3) - (d1 + d2)}) {
        const V x = half * dot(term, axes.e1), y = half * dot(term, axes.e2);
        xx = fma(x, x, xx);
        xy = fma(x, y, xy);
        yy = fma(y, y, yy);
    }
    // Principal axes: the eigenvalues are mean ± difference, and the major axis is at the angle φ with cos 2φ = d /
    // difference.
    const V mean = half * (xx + yy), d = half * (xx - yy), difference = sqrt(fma(d, d, xy * xy));
    const V major = sqrt(mean + difference), minor = sqrt(max(mean - difference, zero));
    const V cos_2phi = select(difference > zero, d / difference, one);
    const V cosine = sqrt(max(half * (one + cos_2phi), zero)), sine = sqrt(max(half * (one - cos_2phi), zero)),
            signed_sine = select(xy < zero, -sine, sine);
    store((major * cosine) * axes.e1 + (major * signed_sine) * axes.e2, blocks.major, i);
    store((minor * cosine) * axes.e2 - (minor * signed_sine) * axes.e1, blocks.minor, i);
}

}  // namespace kagero::shading

/// The exact test whether a ray passes through a triangle. It confirms hits that Embree has found in float.
#pragma once

#include "kernels/intersection/surface.h"

namespace kagero {

/// The corners of one triangle for each lane.
template <class V>
struct Triangle {
    Vec3<V> corner[3];

    /// Returns the centre of a single triangle.
    Vec3<double> center() const { return (1.0 / 3) * (corner[0] + corner[1] + corner[2]); }
    /// Returns true if two single triangles have a common corner.
    bool has_common_corner(const Triangle& other) const {
        for (const Vec3<V>& a : corner)
            for (const Vec3<V>& b : other.corner)
                if (a.x == b.x && a.y == b.y && a.z == b.z) return true;
        return false;
    }

    /// Returns the lanes in which the line x + t·v passes through the triangle. The volume of the tetrahedron of v and
    /// an edge, seen from x, has the same sign for all three edges if the line passes on the inner side of each edge
    /// (Plücker coordinates; Shevtsov et al. 2007). Volumes within the rounding errors of x and of the corners count as
    /// zero, so that lines pass through at least one of two triangles with a common edge. `rounding` is the rounding
    /// error of a coordinate.
    MaskOf<V> contains_line(const Vec3<V>& x, const Vec3<V>& v, const V& rounding) const {
        const V epsilon(ScalarOf<V>(4) * machine_epsilon<ScalarOf<V>>);
        const Vec3<V> a = corner[0] - x, b = corner[1] - x, c = corner[2] - x;
        const V speed = fast_sqrt(dot(v, v));
        MaskOf<V> has_positive = no_lanes<V>(), has_negative = no_lanes<V>();
        const auto add_edge = [&](const Vec3<V>& from, const Vec3<V>& to) {
            const Vec3<V> normal = cross(from, to), across = cross(v, to - from);
            const V volume = dot(v, normal);
            const V uncertainty = fma(rounding, fast_sqrt(dot(across, across)),
                                      epsilon * speed * fast_sqrt(dot(from, from) * dot(to, to)));
            has_positive = has_positive | (volume > uncertainty);
            has_negative = has_negative | (volume < -uncertainty);
        };
        add_edge(a, b);
        add_edge(b, c);
        add_edge(c, a);
        return !(has_positive & has_negative);
    }
};

/// Returns the corners of a triangle of a mesh.
inline Triangle<double> triangle_of(const Surface& surface, std::uint32_t primitive) {
    Triangle<double> triangle;
    const std::uint32_t* index = surface.triangles + 3 * std::size_t(primitive);
    for (int i = 0; i < 3; ++i) {
        const double* v = surface.vertices + 3 * std::size_t(index[i]);
        triangle.corner[i] = {v[0], v[1], v[2]};
    }
    return triangle;
}

/// Returns the triangles that `lanes` have hit. Other lanes get the triangle of the lowest lane in `lanes`.
template <class V, int W = lane_count<V>>
Triangle<V> triangles_of(const Surface* surfaces, const std::uint32_t (&surface)[W],
                         const std::uint32_t (&primitive)[W], std::uint64_t lanes) {
    using S = ScalarOf<V>;
    const int first = __builtin_ctzll(lanes);
    const Triangle<double> of_first = triangle_of(surfaces[surface[first]], primitive[first]);
    std::uint64_t others = 0;
    for (int i = 0; i < W; ++i)
        others |= std::uint64_t((surface[i] != surface[first]) | (primitive[i] != primitive[first])) << i;
    Triangle<V> triangles;
    if (!(others &= lanes)) {
        for (int k = 0; k < 3; ++k) {
            const Vec3<double>& corner = of_first.corner[k];
            triangles.corner[k] = {V(S(corner.x)), V(S(corner.y)), V(S(corner.z))};
        }
        return triangles;
    }
    alignas(64) double coordinates[9][W];
    for (int i = 0; i < W; ++i) {
        const bool is_other = (others >> i) & 1;
        const Surface& hit = surfaces[surface[is_other ? i : first]];
        const std::uint32_t* index = hit.triangles + 3 * std::size_t(primitive[is_other ? i : first]);
        for (int k = 0; k < 3; ++k) {
            const double* corner = hit.vertices + 3 * std::size_t(index[k]);
            for (int axis = 0; axis < 3; ++axis) coordinates[3 * k + axis][i] = corner[axis];
        }
    }
    for (int k = 0; k < 3; ++k)
        triangles.corner[k] = {lanes_of<V>(coordinates[3 * k]), lanes_of<V>(coordinates[3 * k + 1]),
                               lanes_of<V>(coordinates[3 * k + 2])};
    return triangles;
}

/// Returns the lanes of `lanes` in which the line x + t·v passes through the triangle that was hit, or in which the
/// surface is a sphere. `size` is the size of the scene; the rounding of its coordinates depends on it. A line may pass
/// the triangle at `margin` times the size.
template <class V, int W = lane_count<V>>
std::uint64_t confirmed_hits(const Surface* surfaces, const std::uint32_t (&surface)[W],
                             const std::uint32_t (&primitive)[W], std::uint64_t lanes, const Vec3<V>& x,
                             const Vec3<V>& v, double size, double margin = 0) {
    using S = ScalarOf<V>;
    std::uint64_t on_triangles = lanes;
    for (const int i : lanes_in(lanes))
        if (surfaces[surface[i]].kind == Surface::Kind::sphere) on_triangles &= ~(std::uint64_t(1) << i);
    if (!on_triangles) return lanes;
    const V greatest = max(greatest_component(x), V(S(size))),
            rounding = V(max(S(4) * machine_epsilon<S>, S(margin))) * greatest;
    const Triangle<V> triangles = triangles_of<V>(surfaces, surface, primitive, on_triangles);
    return lanes & (~on_triangles | to_bits(triangles.contains_line(x, v, rounding)));
}

}  // namespace kagero

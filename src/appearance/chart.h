/// Charts: maps from points on a surface to texture coordinates u and v, with gradients. The gradients give the part of
/// a texture that a small patch of the surface covers.
#pragma once

#include "appearance/patch.h"
#include "geometry/shapes.h"
#include "scene/vector3.h"

namespace kagero {

/// The two sides of a small parallelogram, as differences of u and v.
struct UvPatch {
    std::array<double, 2> a{}, b{};
};

/// Texture coordinates of a point, and their gradients along the surface.
struct ChartPoint {
    double u = 0, v = 0;
    Double3 u_gradient{}, v_gradient{};
};

/// Linear map from the points of a triangle to u and v, given by the values at one corner and the gradients.
/// gradient[k] contains the derivatives of u and v along axis k. The derivatives of u and v along an axis are adjacent
/// in memory, so that loops over u and v can be vectorized.
struct TriangleChart {
    Double3 corner{};                     ///< Position of the corner.
    std::array<double, 2> uv_at_corner{};
    std::array<std::array<double, 2>, 3> gradient{};
};

/// Returns one chart per triangle; none if the mesh has no u and v.
std::vector<TriangleChart> charts_of(const TriangleMesh& mesh);

/// Returns the differences of u and v over a displacement.
inline std::array<double, 2> uv_difference(const TriangleChart& chart, const Double3& displacement) {
    std::array<double, 2> uv;
    for (std::size_t k = 0; k < 2; ++k)
        uv[k] = chart.gradient[0][k] * displacement[0] + chart.gradient[1][k] * displacement[1] +
                chart.gradient[2][k] * displacement[2];
    return uv;
}
/// Returns u and v of a point on the triangle.
inline std::array<double, 2> triangle_uv(const TriangleChart& chart, const Double3& point) {
    std::array<double, 2> uv = uv_difference(chart, subtract(point, chart.corner));
    for (std::size_t k = 0; k < 2; ++k) uv[k] += chart.uv_at_corner[k];
    return uv;
}

/// Returns u and v of a point on a sphere; `from_center` is its position relative to the centre. u is the longitude as
/// a fraction of a turn, 0.5 at +x and increasing towards +y. v is the latitude, from 0 at −z to 1 at +z.
ChartPoint sphere_uv(const Double3& from_center);

/// Returns u and v of a point on a disk; `from_center` is its position relative to the centre. u is the angle around
/// the normal as a fraction of a turn; its zero is the direction of axes_around(normal)[0]. v increases from 0 at the
/// inner edge to 1 at the outer edge.
ChartPoint disk_uv(const Double3& normal, double inner, double outer, const Double3& from_center);

/// Unit axes of a sky. The zero meridian contains the direction +x, unless +x is a pole.
struct SkyAxes {
    Double3 up;    ///< Pole.
    Double3 zero;  ///< Point of the equator on the zero meridian.
    Double3 east;  ///< Point of the equator 90° east of the zero meridian.
    /// Computes the axes from a vector along the pole, of any length.
    SkyAxes(const Double3& pole);
};

/// Returns u and v of a direction on an equirectangular sky. The pole is at the top, +x is in the middle, and east is
/// to the left. Gradients are per radian.
ChartPoint sky_uv(const Double3& direction, const SkyAxes& axes);

/// Converts the sides of a patch to differences of u and v.
inline UvPatch to_uv(const TriangleChart& chart, const Patch& patch) {
    return {uv_difference(chart, patch.right), uv_difference(chart, patch.below)};
}
inline UvPatch to_uv(const ChartPoint& point, const Patch& patch) {
    return {{dot(point.u_gradient, patch.right), dot(point.v_gradient, patch.right)},
            {dot(point.u_gradient, patch.below), dot(point.v_gradient, patch.below)}};
}

}  // namespace kagero

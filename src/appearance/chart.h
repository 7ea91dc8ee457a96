/// Coordinates u and v on surfaces, to first order: what paint is laid out by, and how much of it a small piece of the
/// surface covers.
#pragma once

#include "appearance/patch.h"
#include "geometry/shapes.h"
#include "scene/vector3.h"

namespace kagero {

/// Two sides of a small parallelogram in u and v.
struct UvPatch {
    std::array<double, 2> a{}, b{};
};

/// A point's u and v, and their gradients within the surface.
struct ChartPoint {
    double u = 0, v = 0;
    Double3 u_gradient{}, v_gradient{};
};

/// u and v are linear on a triangle: those of a corner, and how they grow from there along x, y and z. Side by side, as
/// most of a picture may be painted by them.
struct TriangleChart {
    Double3 corner{};
    std::array<double, 2> at_corner{};
    std::array<std::array<double, 2>, 3> growth{};
};

/// One per triangle; none where the mesh has no uv.
std::vector<TriangleChart> charts_of(const TriangleMesh& mesh);

inline std::array<double, 2> along(const TriangleChart& chart, const Double3& way) {
    std::array<double, 2> uv;
    for (std::size_t k = 0; k < 2; ++k)
        uv[k] = chart.growth[0][k] * way[0] + chart.growth[1][k] * way[1] + chart.growth[2][k] * way[2];
    return uv;
}
inline std::array<double, 2> on_triangle(const TriangleChart& chart, const Double3& point) {
    std::array<double, 2> uv = along(chart, subtract(point, chart.corner));
    for (std::size_t k = 0; k < 2; ++k) uv[k] += chart.at_corner[k];
    return uv;
}

/// u is longitude (+x in the middle, growing towards +y), v latitude about z. Of a point, of any length, from the
/// centre.
ChartPoint on_sphere(const Double3& from_center);

/// u once around from +x made orthogonal to the normal, v from the inner to the outer edge.
ChartPoint on_disk(const Double3& normal, double inner, double outer, const Double3& from_center);

/// The axes of a sky with this pole: the zero meridian runs through +x.
struct SkyAxes {
    Double3 up, zero, east;
    SkyAxes(const Double3& pole);
};

/// An equirectangular sky: the pole is up, +x in the middle, east to the left. Gradients per radian.
ChartPoint on_sky(const Double3& direction, const SkyAxes& axes);

inline UvPatch in_chart(const TriangleChart& chart, const Patch& patch) {
    return {along(chart, patch.right), along(chart, patch.below)};
}
inline UvPatch in_chart(const ChartPoint& point, const Patch& patch) {
    return {{dot(point.u_gradient, patch.right), dot(point.v_gradient, patch.right)},
            {dot(point.u_gradient, patch.below), dot(point.v_gradient, patch.below)}};
}

}  // namespace kagero

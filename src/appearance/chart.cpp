#include "appearance/chart.h"

#include "scene/vector3.h"

#include <algorithm>
#include <limits>
#include <numbers>

namespace kagero {

std::vector<TriangleChart> charts_of(const TriangleMesh& mesh) {
    std::vector<TriangleChart> charts;
    if (mesh.uv.empty()) return charts;
    charts.reserve(mesh.triangles.size() / 3);
    for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
        const std::uint32_t* index = &mesh.triangles[i];
        const Double3 a = vertex(mesh, index[0]);
        const Double3 ab = subtract(vertex(mesh, index[1]), a), ac = subtract(vertex(mesh, index[2]), a),
                      normal = cross(ab, ac);
        // Gradients of the barycentric coordinates of the second and third corner.
        const Double3 second = scaled(cross(ac, normal), 1 / dot(normal, normal)),
                      third = scaled(cross(normal, ab), 1 / dot(normal, normal));
        const auto uv = [&](int corner, std::size_t k) { return mesh.uv[2 * std::size_t{index[corner]} + k]; };
        const auto gradient = [&](std::size_t k) {
            return add(scaled(second, uv(1, k) - uv(0, k)), scaled(third, uv(2, k) - uv(0, k)));
        };
        const Double3 u = gradient(0), v = gradient(1);
        charts.push_back({a, {uv(0, 0), uv(0, 1)}, {{{u[0], v[0]}, {u[1], v[1]}, {u[2], v[2]}}}});
    }
    return charts;
}

ChartPoint sphere_uv(const Double3& from_center) {
    const double r = length(from_center);
    const auto [x, y, z] = scaled(from_center, 1 / r);
    const double latitude = std::asin(std::clamp(z, -1.0, 1.0));
    // At a pole the gradients diverge; the lower bound on the distance from the axis keeps them finite.
    const double rho = std::max(std::hypot(x, y), std::sqrt(std::numeric_limits<double>::epsilon()));
    const double u_scale = 1 / (2 * std::numbers::pi * r * rho * rho), v_scale = 1 / (std::numbers::pi * r * rho);
    return {0.5 + std::atan2(y, x) / (2 * std::numbers::pi), 0.5 + latitude / std::numbers::pi,
            scaled({-y, x, 0}, u_scale), scaled({-z * x, -z * y, rho * rho}, v_scale)};
}

ChartPoint disk_uv(const Double3& normal, double inner, double outer, const Double3& from_center) {
    const auto [x_axis, y_axis] = axes_around(normal);
    const double r = length(from_center), turn = 2 * std::numbers::pi;
    const double x = dot(from_center, x_axis), y = dot(from_center, y_axis), angle = std::atan2(y, x) / turn;
    return {angle < 0 ? angle + 1 : angle, std::clamp((r - inner) / (outer - inner), 0.0, 1.0),
            scaled(subtract(scaled(y_axis, x), scaled(x_axis, y)), 1 / (turn * r * r)),
            scaled(from_center, 1 / (r * (outer - inner)))};
}

SkyAxes::SkyAxes(const Double3& pole) : up(unit(pole)) {
    const auto equator = axes_around(up);
    zero = equator[0];
    east = equator[1];
}

ChartPoint sky_uv(const Double3& direction, const SkyAxes& axes) {
    const auto to_scene = [&axes](const Double3& d) {
        return add(add(scaled(axes.zero, d[0]), scaled(axes.east, d[1])), scaled(axes.up, d[2]));
    };
    ChartPoint point = sphere_uv({dot(direction, axes.zero), dot(direction, axes.east), dot(direction, axes.up)});
    point.u = 1 - point.u;
    point.u_gradient = scaled(to_scene(point.u_gradient), -1);
    point.v_gradient = to_scene(point.v_gradient);
    return point;
}

}  // namespace kagero

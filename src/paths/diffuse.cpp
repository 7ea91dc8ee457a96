#include "paths/diffuse.h"

#include "geometry/shapes.h"
#include "rays/sampler.h"
#include "scene/vector3.h"
#include "spaces/charts.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kagero {
namespace {

/// Returns the solution c of Σ_b columns[b] c_b = n, by Cramer's rule.
Double3 solve_columns(const std::array<Double3, 3>& columns, const Double3& n) {
    const auto& [a, b, c] = columns;
    const double inverse = 1 / dot(a, cross(b, c));
    return {inverse * dot(n, cross(b, c)), inverse * dot(a, cross(n, c)), inverse * dot(a, cross(b, n))};
}

/// Returns the components, in the axes E_b of a rest frame, of the conormal (n, 0) of a surface that is at rest in the
/// frame. The columns of the map are the covectors E_b. They span all covectors that vanish on the 4-velocity, and the
/// conormal is one of these.
Double3 normal_in_frame(const StartMap& map, const Double3& n) {
    std::array<Double3, 3> columns;
    for (std::size_t b = 0; b < 3; ++b) columns[b] = {map.matrix[0][b], map.matrix[1][b], map.matrix[2][b]};
    return unit(solve_columns(columns, n));
}

/// Returns a point in the coordinates of the space of the scene.
Double3 position_in_space(const Plan& plan, const DiffusePoint& point) {
    const Double3 &from = plan.medium(point.medium).description().space.center, &to = plan.description().space.center;
    return add(point.position, subtract(from, to));
}

}  // namespace

DiffuseColor diffuse_color(const Plan& plan, const DiffusePoint& point, const Double3& toward) {
    const Float3 color =
        plan.scene->paints->surface_color(point.surface, point.primitive, position_in_space(plan, point), toward);
    DiffuseColor result;
    const double strength = plan.description().objects[point.surface].emission_strength;
    for (std::size_t k = 0; k < 3; ++k) {
        result.albedo[k] = double(color[k]);
        result.emission[k] = strength * double(color[k]);
    }
    return result;
}

std::optional<SurfaceFrame> SurfaceFrame::at(const Plan& plan, const DiffusePoint& point) {
    const Scene& scene = *plan.medium(point.medium).scene;
    SurfaceFrame frame(scene, point);
    const double q[3] = {point.position[0], point.position[1], point.position[2]};
    StartMap map{};
    const Failure failure =
        null_ray_sign(scene) == 0 ? Failure::no_rest_frame : scene.space.observe(ObserverKind::static_, q, false, map);
    if (failure == Failure::no_rest_frame) {
        frame.normal_ = point.normal;
        return frame;
    }
    if (failure != Failure::none || map.ingoing) return {};
    frame.normal_ = normal_in_frame(map, point.normal);
    frame.map_ = map;
    return frame;
}

RayStart SurfaceFrame::start_along(const Double3& direction) const {
    const double q[3] = {point_.position[0], point_.position[1], point_.position[2]};
    RayStart start = map_ ? ray_in_frame(*map_, direction).start : scene_.space.start(q, direction);
    if (map_ && start.pt != 0) {  // null rays have |p_t| = 1 at surfaces
        const double scale = 1 / std::abs(start.pt);
        for (double& component : start.p) component *= scale;
        start.pt *= scale;
    }
    std::copy_n(q, 3, start.q);
    start.captured = start.escaped = false;
    start.surface = point_.surface;
    start.primitive = point_.primitive;
    if (start.failure == Failure::none &&
        starts_ingoing(scene_.space, scene_.limits.chart_radius, std::nullopt, start.q)) {
        const Hole hole = scene_.space.hole();
        scene_.module().to_ingoing(&hole, &start);
    }
    return start;
}

Double3 cosine_direction(const Double3& normal, const std::array<double, 2>& point) {
    const auto [x, y] = concentric_disk(point);
    const double height = std::sqrt(std::max(0.0, 1 - x * x - y * y));
    const auto [e1, e2] = axes_around(normal);
    return add(scaled(normal, height), add(scaled(e1, x), scaled(e2, y)));
}

ScatteredDirection Scatterer::scatter(const DiffusePoint& point, const SurfaceFrame& frame, const PixelRay& ray,
                                      std::uint32_t bounce) {
    constexpr double light_share = 0.5;
    const std::array<double, 2> square = sample_square(ray, RandomChoice::direction, bounce);
    const LightProposals* proposals = plan_.scene->lights.get();
    if (!proposals || proposals->empty() || !lights_.set(*proposals, position_in_space(plan_, point), frame.normal()))
        return {cosine_direction(frame.normal(), square), 1};
    const double number = sample_number(ray, RandomChoice::strategy, bounce);
    const Double3 direction = number < light_share ? lights_.direction(number / light_share, square)
                                                   : cosine_direction(frame.normal(), square);
    const double scattered = std::max(0.0, dot(direction, frame.normal())) / std::numbers::pi;
    const double density = light_share * lights_.density(direction) + (1 - light_share) * scattered;
    return {direction, scattered / density};
}

}  // namespace kagero

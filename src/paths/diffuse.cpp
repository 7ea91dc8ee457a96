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
    const ObjectDescription& object = plan.description().objects[point.surface];
    const Float3 emission = object.emission ? plan.scene->paints->emission_color(point.surface, point.primitive,
                                                                                 position_in_space(plan, point))
                                            : color;
    const double strength = object.emission ? 1 : object.emission_strength;
    DiffuseColor result;
    for (std::size_t k = 0; k < 3; ++k) {
        result.albedo[k] = double(color[k]);
        result.emission[k] = strength * double(emission[k]);
    }
    return result;
}

std::optional<SurfaceFrame> SurfaceFrame::at(const Plan& plan, const DiffusePoint& point) {
    const Scene& scene = *plan.medium(point.medium).scene;
    SurfaceFrame frame(scene, point);
    frame.normal_ = point.normal;
    if (null_ray_sign(scene) != 0 && !frame.set_from_rays() && !frame.set_from_observer()) return {};
    frame.set_shading_normal();
    return frame;
}

void SurfaceFrame::set_shading_normal() {
    shading_normal_ = normal_;
    if (point_.shading_normal == point_.normal) return;
    if (map_) shading_normal_ = normal_in_frame(*map_, point_.shading_normal);
    else if (!has_covectors_) shading_normal_ = point_.shading_normal;
    else {
        const Double3 components = solve_columns(covectors_, point_.shading_normal);
        shading_normal_ = {};
        for (std::size_t b = 0; b < 3; ++b) shading_normal_ = add(shading_normal_, scaled(axes_[b], components[b]));
        shading_normal_ = unit(shading_normal_);
    }
}

// H is quadratic in the momentum: ∂H/∂p = γ (p − c) with the spatial block γ of the inverse metric and the vector c of
// Module::time_tilts. Three rays determine γ. A surface at rest sees the light with the momentum p − c, whose length in
// γ is the frequency. Its axes are covectors of unit length in γ: the first is along the conormal, and the others
// follow by orthogonalization.
bool SurfaceFrame::set_from_rays() {
    constexpr double tangential_share = 0.1;
    const auto [e1, e2] = axes_around(point_.normal);
    std::array<SurfaceRay, 3> rays{};
    for (SurfaceRay& ray : rays) {
        std::copy_n(point_.position.begin(), 3, ray.q);
        std::copy_n(point_.normal.begin(), 3, ray.normal);
        ray.pt = point_.pt;
    }
    const Space& space = scene_.space;
    double tilts[3][3] = {};
    space.module->time_tilts(space.hamiltonian, space.parameters.data(), rays.data(), 3, tilts);
    offset_ = {tilts[0][0], tilts[0][1], tilts[0][2]};
    const std::array<Double3, 3> tangential{Double3{}, scaled(e1, tangential_share), scaled(e2, tangential_share)};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t k = 0; k < 3; ++k) rays[i].p[k] = offset_[k] + tangential[i][k];
    std::array<Continuation, 3> continuations{};
    space.module->continue_rays(space.hamiltonian, space.parameters.data(), rays.data(), 3, continuations.data());
    std::array<Double3, 3> momenta, velocities;
    for (std::size_t i = 0; i < 3; ++i) {
        const Continuation& ray = continuations[i];
        if (!ray.exists) return false;
        momenta[i] = subtract({ray.p[0], ray.p[1], ray.p[2]}, offset_);
        velocities[i] = {ray.velocity[0], ray.velocity[1], ray.velocity[2]};
    }
    const auto raised = [&](const Double3& covector) {  // γ times a covector
        const Double3 share = solve_columns(momenta, covector);
        return add(add(scaled(velocities[0], share[0]), scaled(velocities[1], share[1])),
                   scaled(velocities[2], share[2]));
    };
    const double square = dot(momenta[0], velocities[0]), frequency = std::sqrt(square);
    axes_ = {point_.normal, e1, e2};
    for (std::size_t b = 0; b < 3; ++b) {
        Double3 covector = axes_[b];
        const Double3 vector = raised(covector);
        for (std::size_t a = 0; a < b; ++a)
            covector = subtract(covector, scaled(covectors_[a], dot(covectors_[a], vector) / square));
        const double length_in_metric = std::sqrt(dot(covector, raised(covector)));
        covectors_[b] = scaled(covector, frequency / length_in_metric);
        if (!(length_in_metric > 0) || !std::isfinite(dot(covectors_[b], covectors_[b]))) return false;
    }
    has_covectors_ = true;
    return true;
}

bool SurfaceFrame::set_from_observer() {
    const double q[3] = {point_.position[0], point_.position[1], point_.position[2]};
    StartMap map{};
    const Failure failure = scene_.space.observe(ObserverKind::static_, q, false, map);
    if (failure == Failure::no_rest_frame) return true;  // directions are those of dq/dλ
    if (failure != Failure::none || map.ingoing) return false;
    normal_ = normal_in_frame(map, point_.normal);
    map_ = map;
    return true;
}

RayStart SurfaceFrame::start_along(const Double3& direction) const {
    const double q[3] = {point_.position[0], point_.position[1], point_.position[2]};
    RayStart start{};
    if (has_covectors_) {
        for (std::size_t k = 0; k < 3; ++k) {
            start.p[k] = offset_[k];
            for (std::size_t b = 0; b < 3; ++b) start.p[k] += dot(direction, axes_[b]) * covectors_[b][k];
        }
        start.pt = point_.pt;
    } else start = map_ ? ray_in_frame(*map_, direction).start : scene_.space.start(q, direction);
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
    const Double3& normal = frame.shading_normal();
    const auto is_outward = [&](const Double3& direction) { return dot(direction, frame.normal()) > 0; };
    if (!proposals || proposals->empty() || !lights_.set(*proposals, position_in_space(plan_, point), normal)) {
        const Double3 direction = cosine_direction(normal, square);
        return {direction, is_outward(direction) ? 1.0 : 0.0};
    }
    const double number = sample_number(ray, RandomChoice::strategy, bounce);
    const Double3 direction =
        number < light_share ? lights_.direction(number / light_share, square) : cosine_direction(normal, square);
    if (!is_outward(direction)) return {direction, 0};
    const double scattered = std::max(0.0, dot(direction, normal)) / std::numbers::pi;
    const double density = light_share * lights_.density(direction) + (1 - light_share) * scattered;
    return {direction, scattered / density};
}

}  // namespace kagero

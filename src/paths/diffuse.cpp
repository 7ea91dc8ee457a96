#include "paths/diffuse.h"

#include "geometry/shapes.h"
#include "rays/sampler.h"
#include "scene/vector3.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kagero {
namespace {

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

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

/// Returns the share of the rays that a surface sends toward lights. The factor of the others is the inverse of the
/// rest. With the share 1 − albedo, light toward which no ray is sent keeps its weight from surface to surface; a
/// greater share would let the weights, and the noise of bright rooms, grow without limit. The first surfaces of a path
/// have greater shares, since most of the light of the lamps is on short paths: 1/2, 1/4, …, so that all of them
/// together multiply the weight by at most 3.5.
double light_share(double albedo, std::uint32_t scatterings) {
    return std::min(0.5, std::max(1 - albedo, std::pow(0.5, double(scatterings) + 1)));
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
                                      const PathState& path) {
    const std::array<double, 2> square = sample_square(ray, RandomChoice::direction, path.bounces);
    const LightProposals* proposals = plan_.scene->lights.get();
    const Double3& normal = frame.shading_normal();
    const auto is_outward = [&](const Double3& direction) { return dot(direction, frame.normal()) > 0; };
    if (!proposals || proposals->empty() || !lights_.set(*proposals, position_in_space(plan_, point), normal)) {
        const Double3 direction = cosine_direction(normal, square);
        return {direction, is_outward(direction) ? 1.0 : 0.0};
    }
    const double number = sample_number(ray, RandomChoice::strategy, path.bounces),
                 share = light_share(point.albedo, path.scatterings);
    const Double3 direction =
        number < share ? lights_.direction(number / share, square) : cosine_direction(normal, square);
    if (!is_outward(direction)) return {direction, 0};
    const double scattered = std::max(0.0, dot(direction, normal)) / std::numbers::pi;
    const double density = share * lights_.density(direction) + (1 - share) * scattered;
    return {direction, scattered / density};
}

}  // namespace kagero

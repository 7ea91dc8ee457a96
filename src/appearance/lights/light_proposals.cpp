#include "appearance/lights/light_proposals.h"

#include "geometry/shapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kagero {
namespace {

double luminance_of_color(const Double3& color) { return 0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2]; }

/// Returns the mean luminance of a paint.
double luminance_of_paint(const LoadedPaint& paint) {
    if (paint.paint.kind != Paint::Kind::texture) return luminance_of_color(paint.paint.color);
    if (!paint.coarser || paint.coarser->empty()) return 0;
    const std::vector<float>& rgb = paint.coarser->back().rgb;
    const Double3& factor = paint.paint.factor;
    return luminance_of_color({factor[0] * double(rgb[0]), factor[1] * double(rgb[1]), factor[2] * double(rgb[2])});
}

/// Returns the greatest luminance that an object emits on one of its faces; 0 if it emits nothing.
double emitted_luminance(const ObjectDescription& description, const ShadedObject& object) {
    if (object.emission) return luminance_of_paint(*object.emission);
    const bool is_diffuse = description.material == Material::diffuse;
    if (!is_diffuse && description.material != Material::surface) return 0;
    if (description.temperature > 0) return 1;  // a disk has the luminance 1 at its inner edge
    double greatest = 0;
    for (const LoadedPaint& paint : object.paints) greatest = std::max(greatest, luminance_of_paint(paint));
    return is_diffuse ? description.emission_strength * greatest : greatest;
}

/// Returns the centre and the radius of a sphere around an object.
std::pair<Double3, double> sphere_around(const ObjectDescription& description, const ObjectGeometry& object) {
    if (object.shape == Shape::sphere) return {object.center, description.radius};
    const std::vector<double>& vertices = object.mesh.vertices;
    Double3 least{vertices[0], vertices[1], vertices[2]}, greatest = least;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        least[i % 3] = std::min(least[i % 3], vertices[i]);
        greatest[i % 3] = std::max(greatest[i % 3], vertices[i]);
    }
    const Double3 center = scaled(add(least, greatest), 0.5);
    double square = 0;
    for (std::size_t i = 0; i < vertices.size(); i += 3) {
        const Double3 offset = subtract({vertices[i], vertices[i + 1], vertices[i + 2]}, center);
        square = std::max(square, dot(offset, offset));
    }
    return {center, std::sqrt(square)};
}

}  // namespace

LightProposals::LightProposals(const SceneDescription& scene, const SceneGeometry& geometry, const Paints& paints)
    : sky_(SkyDistribution::of(paints.sky(false))) {
    for (std::uint32_t i = 0; i < scene.objects.size(); ++i) {
        const double luminance = emitted_luminance(scene.objects[i], paints.object(i));
        if (!(luminance > 0)) continue;
        const auto [center, radius] = sphere_around(scene.objects[i], geometry.objects()[i]);
        lights_.push_back({center, radius, luminance});
    }
}

bool LightProposals::Around::set(const LightProposals& proposals, const Double3& point, const Double3& normal) {
    cones_.clear();
    sky_ = proposals.sky_ ? &*proposals.sky_ : nullptr;
    total_ = sky_weight_ = sky_ ? std::numbers::pi * sky_->mean_luminance() : 0;
    for (const Light& light : proposals.lights_) {
        const Double3 way = subtract(light.center, point);
        const double distance = length(way), sine = light.radius / distance;
        if (!(sine < 1)) continue;
        const Double3 axis = scaled(way, 1 / distance);
        const double cosine = dot(axis, normal);
        if (cosine + sine <= 0) continue;  // the light is below the horizon
        const double height = sine * sine / (1 + std::sqrt(1 - sine * sine));
        const double weight = light.luminance * height * std::max(cosine, 0.5 * sine);
        cones_.push_back({axis, height, weight});
        total_ += weight;
    }
    return total_ > 0;
}

Double3 LightProposals::Around::direction(double number, const std::array<double, 2>& point) const {
    double rest = number * total_;
    for (const Cone& cone : cones_) {
        rest -= cone.weight;
        if (rest > 0 && (sky_ || &cone != &cones_.back())) continue;
        const double down = point[0] * cone.height, cosine = 1 - down, sine = std::sqrt(down * (1 + cosine)),
                     angle = 2 * std::numbers::pi * point[1];
        const auto [e1, e2] = axes_around(cone.axis);
        return add(scaled(cone.axis, cosine),
                   add(scaled(e1, sine * std::cos(angle)), scaled(e2, sine * std::sin(angle))));
    }
    return sky_->direction(point);
}

double LightProposals::Around::density(const Double3& direction) const {
    double sum = sky_ ? sky_weight_ * sky_->density(direction) : 0;
    for (const Cone& cone : cones_) {
        const Double3 offset = subtract(direction, cone.axis);
        if (dot(offset, offset) <= 2 * cone.height) sum += cone.weight / (2 * std::numbers::pi * cone.height);
    }
    return sum / total_;
}

}  // namespace kagero

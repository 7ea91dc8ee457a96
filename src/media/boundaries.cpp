#include "media/boundaries.h"

#include "error.h"
#include "media/closed_mesh.h"
#include "scene/value.h"

#include <algorithm>

namespace kagero {
namespace {

/// Returns the boundary of an object. Throws InputError if a mesh is not closed and consistently oriented.
MediumBoundary boundary_of(const SceneDescription& scene, std::uint32_t object, const ObjectGeometry& geometry,
                           double unit) {
    const ObjectDescription& description = scene.objects[object];
    MediumBoundary boundary{exact_surface(description, object, geometry), description.interior, description.exterior};
    if (!boundary.mesh) return boundary;
    const ClosedMesh closed = check_closed(geometry.mesh, scene.space.center, unit);
    // Boxes and rooms are closed, although rounding may displace the corners of their faces.
    if (description.shape == Shape::mesh && !closed.defect.empty())
        throw InputError(description.material_location,
                         "object." + description.name + ".material = \"boundary\" needs a closed mesh, but " +
                             to_toml(description.file) + " " + closed.defect + ", or choose another material");
    boundary.outward_sign = closed.signed_volume < 0 ? -1 : 1;
    return boundary;
}

/// Returns the first crossing of a ray with a boundary. `start` is null unless the ray starts on this boundary.
Crossing crossing_of(const MediumBoundary& boundary, const StraightRay& ray, const SurfacePoint* start) {
    Crossing crossing;
    if (boundary.tree) boundary.tree->add_crossings(ray, start ? start->triangle : no_triangle, crossing);
    else add_sphere(ray, boundary.center, boundary.radius, start != nullptr, crossing);
    return crossing;
}

/// The first crossing of a ray with one boundary.
struct BoundaryCrossing {
    double distance;
    FirstBoundary first;
};

/// Returns the boundary that decides among those that a ray crosses first, at the same point. A boundary that the ray
/// leaves takes precedence, because the exterior of a touching boundary is another region. Returns no value if
/// boundaries that take equal precedence state different media.
std::optional<FirstBoundary> decide(const std::vector<BoundaryCrossing>& crossings) {
    if (crossings.empty()) return FirstBoundary{};
    const BoundaryCrossing& nearest =
        *std::min_element(crossings.begin(), crossings.end(),
                          [](const auto& one, const auto& other) { return one.distance < other.distance; });
    std::optional<FirstBoundary> decision;
    for (const bool from_inside : {true, false}) {
        for (const auto& [distance, first] : crossings) {
            const double width = contact_width(*first.boundary, *nearest.first.boundary);
            if (distance > nearest.distance + width || first.from_inside != from_inside) continue;
            if (decision && decision->medium != first.medium) return std::nullopt;
            if (!decision) decision = first;
        }
        if (decision) return decision;
    }
    return decision;
}

}  // namespace

Boundaries::Boundaries(const SceneDescription& scene, const SceneGeometry& geometry, double unit) {
    for (std::uint32_t i = 0; i < scene.objects.size(); ++i)
        if (scene.objects[i].material == Material::boundary)
            all_.push_back(boundary_of(scene, i, geometry.objects()[i], unit));
}

std::optional<FirstBoundary> Boundaries::cast(const StraightRay& ray, const SurfacePoint* start) const {
    std::vector<BoundaryCrossing> crossings;
    double nearest = std::numeric_limits<double>::infinity(), uncertain = nearest;
    for (const MediumBoundary& boundary : all_) {
        const Crossing crossing = crossing_of(boundary, ray, start && start->boundary == &boundary ? start : nullptr);
        uncertain = std::min(uncertain, crossing.uncertain_distance - boundary.rounding);
        if (!(crossing.distance < std::numeric_limits<double>::infinity())) continue;
        nearest = std::min(nearest, crossing.distance);
        const bool from_inside = crossing.against_normal == (boundary.outward_sign < 0);
        crossings.push_back(
            {crossing.distance, {&boundary, from_inside, from_inside ? boundary.interior : boundary.exterior}});
    }
    if (uncertain < nearest) return std::nullopt;
    return decide(crossings);
}

bool Boundaries::touch(const SurfacePoint& point) const {
    return std::any_of(all_.begin(), all_.end(), [&](const MediumBoundary& boundary) {
        const bool is_own = point.boundary == &boundary;
        const double width = is_own ? boundary.rounding : contact_width(*point.boundary, boundary);
        if (boundary.tree)
            return boundary.tree->nearest(point.position, is_own ? point.triangle : no_triangle, width).distance <
                   width;
        return !is_own && std::abs(length(subtract(point.position, boundary.center)) - boundary.radius) < width;
    });
}

Double3 spread_direction(int i, int count) {
    const double height = 2 * (i + 0.437) / count - 1, width = std::sqrt(1 - height * height),
                 angle = 2.39996 * i + 0.7;
    return unit({width * std::cos(angle), width * std::sin(angle), height});
}

}  // namespace kagero

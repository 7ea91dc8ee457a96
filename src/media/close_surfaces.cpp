#include "media/close_surfaces.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

/// Rounding error of Embree's queries, as a share of the size of the scene.
constexpr double query_rounding = 4e-6;

/// Number of times that a ray may cross the gap between two surfaces at an angle: the distance along it is greater.
constexpr double greatest_slant = 64;

bool boxes_come_close(const Bounds& one, const Bounds& other, double limit) {
    for (std::size_t i = 0; i < 3; ++i)
        if (one.lower[i] > other.upper[i] + limit || other.lower[i] > one.upper[i] + limit) return false;
    return true;
}

}  // namespace

CloseSurfaces::CloseSurfaces(const SceneDescription& scene, const SceneGeometry& geometry, const Boundaries& boundaries)
    : reach_(query_rounding * geometry.diagonal()), close_(scene.objects.size()) {
    for (const ObjectDescription& object : scene.objects)
        is_boundary_.push_back(object.material == Material::boundary);
    others_.reserve(scene.objects.size());
    for (std::uint32_t i = 0; i < scene.objects.size(); ++i)
        if (!is_boundary_[i] && scene.objects[i].shape != Shape::disk)  // a disk ends before its outer triangles do
            others_.push_back(exact_surface(scene.objects[i], i, geometry.objects()[i]));
    const auto add_if_close = [&](const ExactSurface& one, const ExactSurface& other) {
        const double limit = std::max(reach_, contact_width(one, other));
        if (!boxes_come_close(one.bounds, other.bounds, limit) || !come_close(one, other, limit)) return;
        close_[one.object].push_back(&other);
        close_[other.object].push_back(&one);
    };
    const std::vector<MediumBoundary>& all = boundaries.all();
    for (std::size_t i = 0; i < all.size(); ++i) {
        for (std::size_t k = 0; k < i; ++k) add_if_close(all[i], all[k]);
        for (const ExactSurface& other : others_) add_if_close(all[i], other);
    }
    surfaces_.resize(scene.objects.size());
    for (const MediumBoundary& boundary : all) surfaces_[boundary.object] = &boundary;
    for (const ExactSurface& other : others_) surfaces_[other.object] = &other;
}

/// Returns the crossing of a ray through q with the part of a surface that is close to q; none if there is no such part,
/// or if the ray passes it on the outside.
std::optional<CloseSurfaces::RayCrossing> CloseSurfaces::crossing_near(const ExactSurface& surface, const Double3& q,
                                                                       const Double3& direction) const {
    const double limit = std::max(reach_, surface.rounding + surface.file_rounding);
    RayCrossing crossing{&surface, 0, 0, {}};
    if (!surface.tree) {
        const Double3 offset = subtract(q, surface.center);
        const double height = length(offset) - surface.radius, along = dot(offset, direction);
        if (std::abs(height) > limit) return std::nullopt;
        // The roots of |offset + s·direction|² = radius², of which the one close to 0 is computed without cancellation.
        const double product = height * (length(offset) + surface.radius), discriminant = along * along - product;
        if (discriminant < 0) return std::nullopt;
        const double far_root = -along - std::copysign(std::sqrt(discriminant), along);
        crossing.distance = far_root != 0 ? product / far_root : 0;
        crossing.normal = unit(add(offset, scaled(direction, crossing.distance)));
    } else {
        const NearestTriangle nearest = surface.tree->nearest(q, no_triangle, limit);
        if (nearest.triangle == no_triangle) return std::nullopt;
        const std::uint32_t* index = &surface.mesh->triangles[3 * std::size_t{nearest.triangle}];
        const Double3 a = vertex(*surface.mesh, index[0]), b = vertex(*surface.mesh, index[1]),
                      c = vertex(*surface.mesh, index[2]);
        crossing.primitive = nearest.triangle;
        crossing.normal = unit(cross(subtract(b, a), subtract(c, a)));
        crossing.distance = dot(subtract(a, q), crossing.normal) / dot(direction, crossing.normal);
        if (!std::isfinite(crossing.distance)) return std::nullopt;
        const Double3 at = add(q, scaled(direction, crossing.distance));
        const double beside = surface.tree->nearest(at, no_triangle, limit).distance;
        if (beside > surface.rounding) return std::nullopt;
    }
    return std::abs(crossing.distance) <= greatest_slant * limit ? std::optional(crossing) : std::nullopt;
}

PointOnSurface CloseSurfaces::first_on_ray(const PointOnSurface& hit, const Double3& direction, double length) const {
    const ExactSurface& own = *surfaces_[hit.surface];
    std::vector<RayCrossing> crossings;
    if (const auto crossing = crossing_near(own, hit.position, direction))
        crossings.push_back({&own, hit.primitive, crossing->distance, crossing->normal});
    else return hit;
    for (const ExactSurface* other : close_[hit.surface]) {
        constexpr double share_before_start = 1 - 1e-6;  // the ray may have started on this surface
        const auto crossing = crossing_near(*other, hit.position, direction);
        if (crossing && crossing->distance > -share_before_start * length) crossings.push_back(*crossing);
    }
    if (crossings.size() == 1) return hit;
    std::stable_sort(crossings.begin(), crossings.end(),
                     [](const RayCrossing& one, const RayCrossing& other) { return one.distance < other.distance; });
    const RayCrossing& first = crossings.front();
    const auto touches_first = [&](const RayCrossing& crossing) {
        const double gap = (crossing.distance - first.distance) * std::abs(dot(direction, first.normal));
        return gap <= contact_width(*first.surface, *crossing.surface);
    };
    const auto end = std::find_if_not(crossings.begin(), crossings.end(), touches_first);
    auto met = std::find_if(crossings.begin(), end,
                            [&](const RayCrossing& crossing) { return !is_boundary(*crossing.surface); });
    if (met == end) --met;
    if (met->surface == &own) return hit;
    return {met->surface->object, met->primitive, add(hit.position, scaled(direction, met->distance))};
}

}  // namespace kagero

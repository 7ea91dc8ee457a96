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
    : reach_(query_rounding * geometry.diagonal()), outward_signs_(scene.objects.size(), 0),
      close_(scene.objects.size()), surfaces_(scene.objects.size(), nullptr) {
    for (const MediumBoundary& boundary : boundaries.all()) {
        outward_signs_[boundary.object] = boundary.outward_sign;
        surfaces_[boundary.object] = &boundary;
    }
    others_.reserve(scene.objects.size());
    for (std::uint32_t i = 0; i < scene.objects.size(); ++i) {
        const ObjectDescription& object = scene.objects[i];
        if (surfaces_[i] || object.shape == Shape::disk) continue;  // a disk ends before its outer triangles do
        const Bounds bounds = bounds_of_surface(object, geometry.objects()[i]);
        const bool may_be_close =
            std::any_of(boundaries.all().begin(), boundaries.all().end(), [&](const MediumBoundary& boundary) {
                return boxes_come_close(bounds, boundary.bounds, 2 * reach_);
            });
        if (may_be_close) surfaces_[i] = &others_.emplace_back(exact_surface(object, i, geometry.objects()[i]));
    }
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
}

/// Returns the crossing of a ray through q with the part of a surface that is close to q; none if there is no such
/// part, or if the ray passes it on the outside.
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
        crossing.outward = unit(add(offset, scaled(direction, crossing.distance)));
    } else {
        const NearestTriangle nearest = surface.tree->nearest(q, no_triangle, limit);
        if (nearest.triangle == no_triangle) return std::nullopt;
        crossing.primitive = nearest.triangle;
        crossing.outward =
            scaled(normal_of(*surface.mesh, nearest.triangle), outward_signs_[surface.object] < 0 ? -1 : 1);
        const Double3 corner = vertex(*surface.mesh, surface.mesh->triangles[3 * std::size_t{nearest.triangle}]);
        crossing.distance = dot(subtract(corner, q), crossing.outward) / dot(direction, crossing.outward);
        if (!std::isfinite(crossing.distance)) return std::nullopt;
        const Double3 at = add(q, scaled(direction, crossing.distance));
        const double beside = surface.tree->nearest(at, no_triangle, limit).distance;
        if (beside > surface.rounding) return std::nullopt;
    }
    return std::abs(crossing.distance) <= greatest_slant * limit ? std::optional(crossing) : std::nullopt;
}

SurfacesOnRay CloseSurfaces::meet(const PointOnSurface& hit, const Double3& direction, double length) const {
    const ExactSurface& own = *surfaces_[hit.surface];
    const auto own_crossing = crossing_near(own, hit.position, direction);
    if (!own_crossing) return {hit, hit};
    std::vector<RayCrossing> crossings{{&own, hit.primitive, own_crossing->distance, own_crossing->outward}};
    for (const ExactSurface* other : close_[hit.surface]) {
        constexpr double share_before_start = 1 - 1e-6;  // the ray may have started on this surface
        const auto crossing = crossing_near(*other, hit.position, direction);
        if (crossing && crossing->distance > -share_before_start * length) crossings.push_back(*crossing);
    }
    // At equal distances, up to rounding, the ray leaves one boundary before it enters another one.
    const double rounding = 1e-6 * own.rounding;
    const auto enters = [&](const RayCrossing& crossing) { return dot(direction, crossing.outward) < 0; };
    std::stable_sort(crossings.begin(), crossings.end(), [&](const RayCrossing& one, const RayCrossing& other) {
        const auto position = [&](const RayCrossing& crossing) {
            return crossing.distance + (enters(crossing) ? rounding : 0);
        };
        return position(one) < position(other);
    });
    const RayCrossing& first = crossings.front();
    const auto touches_first = [&](const RayCrossing& crossing) {
        const double gap = (crossing.distance - first.distance) * std::abs(dot(direction, first.outward));
        return gap <= contact_width(*first.surface, *crossing.surface);
    };
    const auto end = std::find_if_not(crossings.begin(), crossings.end(), touches_first);
    const auto opaque = std::find_if(crossings.begin(), end,
                                     [&](const RayCrossing& crossing) { return !is_boundary(*crossing.surface); });
    const auto point = [&](const RayCrossing& crossing) -> PointOnSurface {
        if (crossing.surface == &own) return hit;
        return {crossing.surface->object, crossing.primitive, add(hit.position, scaled(direction, crossing.distance))};
    };
    if (opaque != end) return {point(*opaque), point(*opaque)};
    return {point(first), point(*(end - 1))};
}

}  // namespace kagero

/// The boundaries of media in a scene, and straight rays that cross them.
#pragma once

#include "media/exact_surface.h"

#include <optional>

namespace kagero {

/// An object with `material = "boundary"`.
struct MediumBoundary : ExactSurface {
    std::uint32_t interior = 0, exterior = 0;  ///< Indices of the media.
    int outward_sign = 1;                      ///< −1 if the normals of the triangles point to the interior.
};

/// The boundary that a ray crosses first, and the medium in front of it.
struct FirstBoundary {
    const MediumBoundary* boundary = nullptr;  ///< Null if the ray crosses none; the medium is then [space].
    bool from_inside = false;                  ///< True if the ray moves from the interior to the exterior.
    std::uint32_t medium = 0;
};

/// A point on a boundary at which a ray starts: the start is not a crossing.
struct SurfacePoint {
    const MediumBoundary* boundary;
    std::uint32_t triangle;  ///< Index of the triangle; no_triangle for a sphere.
    Double3 position, outward;
};

/// Owns the boundaries of a scene. Coordinates are relative to `space.center`, in the unit of the kernels.
class Boundaries {
public:
    /// Finds the boundaries. Throws InputError if one of them is not a closed surface. `geometry` must outlive this
    /// object; `unit` is Scene::unit.
    Boundaries(const SceneDescription& scene, const SceneGeometry& geometry, double unit);

    const std::vector<MediumBoundary>& all() const { return all_; }
    /// Returns the first boundary on a ray. Returns no value if it is uncertain, because the ray passes within rounding
    /// of an edge, is nearly tangent, or crosses boundaries of different media at the same point. If the ray starts on
    /// a boundary, `start` is its start.
    std::optional<FirstBoundary> cast(const StraightRay& ray, const SurfacePoint* start = nullptr) const;
    /// Returns true if another boundary, or another part of the same one, touches a point of a boundary within
    /// rounding.
    bool touch(const SurfacePoint& point) const;

private:
    std::vector<MediumBoundary> all_;
};

/// Returns direction i of `count` directions that are spread over the sphere, none of them along an axis or diagonal.
Double3 spread_direction(int i, int count);

}  // namespace kagero

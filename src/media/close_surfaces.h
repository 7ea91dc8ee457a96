/// Surfaces that touch boundaries of media, or nearly touch them: a plate on a table, a mirror on the back of a glass.
///
/// The kernels find hits with Embree, whose coordinates are floats. Either of two surfaces that are closer to each
/// other than their rounding can be the one that a ray is found to hit. Here, the coordinates in double precision
/// decide.
#pragma once

#include "media/boundaries.h"

#include <optional>
#include <vector>

namespace kagero {

/// A point of a surface.
struct PointOnSurface {
    std::uint32_t surface, primitive;  ///< The object, and its triangle.
    Double3 position;
};

/// The surfaces that a ray meets at a point where surfaces touch each other: the first one and the last one.
struct SurfacesOnRay {
    PointOnSurface first, last;
};

/// Surfaces that come closer to each other than Embree's coordinates distinguish. At least one of them is a boundary.
class CloseSurfaces {
public:
    /// Finds the surfaces. `boundaries` and `geometry` must outlive this object.
    CloseSurfaces(const SceneDescription& scene, const SceneGeometry& geometry, const Boundaries& boundaries);

    /// Returns true if another surface is close to a part of this one.
    bool are_close_to(std::uint32_t surface) const { return !close_[surface].empty(); }
    /// Returns the surfaces that a ray meets in place of `hit`, or `hit`. The ray is straight there, has the unit
    /// direction `direction`, and started at the distance `length` before the hit. The last surface is another one than
    /// the first only where boundaries touch: light passes from the one directly into the medium beyond the other. If a
    /// surface that is not a boundary touches the first one, no light passes between them, and it replaces both.
    SurfacesOnRay meet(const PointOnSurface& hit, const Double3& direction, double length) const;

private:
    /// A surface that a ray crosses, at a distance from its hit.
    struct RayCrossing {
        const ExactSurface* surface;
        std::uint32_t primitive;
        double distance;
        Double3 outward;  ///< Unit normal to the exterior of a boundary; of other surfaces, a unit normal.
    };

    std::optional<RayCrossing> crossing_near(const ExactSurface& surface, const Double3& q,
                                             const Double3& direction) const;
    bool is_boundary(const ExactSurface& surface) const { return outward_signs_[surface.object] != 0; }

    double reach_;                      ///< Distance that Embree's coordinates do not distinguish from 0.
    std::vector<ExactSurface> others_;  ///< Surfaces that are not boundaries.
    // By the index of the object:
    std::vector<int> outward_signs_;                       ///< MediumBoundary::outward_sign; 0 for other surfaces.
    std::vector<std::vector<const ExactSurface*>> close_;  ///< The surfaces close to each surface.
    std::vector<const ExactSurface*> surfaces_;            ///< The surfaces; null if they are not close to any.
};

}  // namespace kagero

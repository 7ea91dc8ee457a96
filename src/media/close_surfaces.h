/// Surfaces that touch boundaries of media, or nearly touch them: a plate on a table, a mirror on the back of a glass.
///
/// The kernels find hits with Embree, whose coordinates are floats. Of two surfaces closer to each other than their
/// rounding, either can be the one that a ray is found to hit. Here, the coordinates in double precision decide.
#pragma once

#include "media/boundaries.h"

#include <span>

namespace kagero {

/// A point of a surface.
struct PointOnSurface {
    std::uint32_t surface, primitive;  ///< The object, and its triangle.
    Double3 position;
};

/// Surfaces of which at least one is a boundary, and which come closer to each other than Embree's coordinates tell.
class CloseSurfaces {
public:
    /// Finds the surfaces. `boundaries` and `geometry` must outlive this object.
    CloseSurfaces(const SceneDescription& scene, const SceneGeometry& geometry, const Boundaries& boundaries);

    /// Returns true if another surface is close to a part of this one.
    bool are_close_to(std::uint32_t surface) const { return !close_[surface].empty(); }
    /// Returns the surface that a ray meets in place of `hit`, or `hit`. The ray is straight there, has the unit
    /// direction `direction`, and started at the distance `length` before the hit. Of surfaces that touch each other, a
    /// surface that is not a boundary takes precedence: no light passes between it and the boundary. Otherwise, the last
    /// boundary does, and the light passes directly into the medium beyond it.
    PointOnSurface first_on_ray(const PointOnSurface& hit, const Double3& direction, double length) const;

private:
    /// A surface that a ray crosses, at a distance from its hit.
    struct RayCrossing {
        const ExactSurface* surface;
        std::uint32_t primitive;
        double distance;
        Double3 normal;
    };

    std::optional<RayCrossing> crossing_near(const ExactSurface& surface, const Double3& q,
                                             const Double3& direction) const;
    bool is_boundary(const ExactSurface& surface) const { return is_boundary_[surface.object]; }

    double reach_;                                          ///< Distance that Embree's coordinates cannot tell from 0.
    std::vector<ExactSurface> others_;                      ///< Surfaces that are not boundaries.
    std::vector<bool> is_boundary_;                         ///< By the index of the object.
    std::vector<std::vector<const ExactSurface*>> close_;   ///< The surfaces close to each object.
    std::vector<const ExactSurface*> surfaces_;             ///< The surface of each object that has close ones.
};

}  // namespace kagero

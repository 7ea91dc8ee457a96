/// Construction of the Embree scene that the kernels query.
#pragma once

#include "geometry/clearance/bounds.h"
#include "geometry/sphere_primitive.h"

#include <rtcore.h>

namespace kagero {

/// Flat ring to which a surface of triangles is restricted: hits that are not between its radii are rejected. The test
/// is in single precision.
struct Ring {
    std::uint32_t surface;  ///< Index of the surface.
    Double3 center;
    double inner, outer;  ///< Radii.
};

/// Owns an Embree device and one committed scene. Embree's geometry IDs are indices of surfaces.
class EmbreeScene {
public:
    /// Builds the scene. Surface coordinates q are relative to `space.center`; Embree's coordinates are (q −
    /// shift)·scale. The scale must be the same for all axes if rays are intersected with spheres or rings.
    /// `triangle_counts` has one entry per surface. Throws RunError if Embree reports an error.
    EmbreeScene(const std::vector<Surface>& surfaces, const std::vector<std::size_t>& triangle_counts,
                const std::vector<Ring>& rings, const double shift[3], const Double3& scale);
    ~EmbreeScene();
    EmbreeScene(const EmbreeScene&) = delete;
    EmbreeScene& operator=(const EmbreeScene&) = delete;

    RTCScene scene() const { return scene_; }

    /// Ring in Embree's coordinates, with squared radii; read by the intersection filter.
    struct FloatRing {
        float center[3], inner_squared, outer_squared;
    };

private:
    /// Sets the intersection filters of the surfaces that are restricted to rings.
    void attach_rings(const std::vector<Ring>& rings, const double shift[3], double scale);

    std::vector<FloatRing> rings_;          ///< Elements to which Embree's user data points.
    std::vector<SpherePrimitive> spheres_;  ///< Elements to which Embree's user data points.
    RTCDevice device_ = nullptr;
    RTCScene scene_ = nullptr;
};

}  // namespace kagero

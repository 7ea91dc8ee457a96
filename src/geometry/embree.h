/// The Embree scene that kernels query.
#pragma once

#include "geometry/bounds.h"

#include <rtcore.h>

namespace kagero {

/// A flat ring within a surface of triangles: only what lies between its radii is there, to the rounding of float.
struct Ring {
    std::uint32_t surface;
    Double3 center;
    double inner, outer;
};

/// Owns a device and one committed scene; geometry identifiers are indices of surfaces.
class EmbreeScene {
public:
    /// Surfaces in coordinates relative to `space.center`; Embree's are (q − shift)·scale, where spheres and rings want
    /// one scale for all axes. Throws RunError when Embree refuses.
    EmbreeScene(const std::vector<Surface>& surfaces, const std::vector<std::size_t>& vertex_counts,
                const std::vector<std::size_t>& triangle_counts, const std::vector<Ring>& rings, const double shift[3],
                const Double3& scale);
    ~EmbreeScene();
    EmbreeScene(const EmbreeScene&) = delete;
    EmbreeScene& operator=(const EmbreeScene&) = delete;

    RTCScene scene() const { return scene_; }

    /// A ring in Embree's coordinates, for the filter that sees every hit.
    struct FloatRing {
        float center[3], inner2, outer2;
    };

private:
    void attach_rings(const std::vector<Ring>& rings, const double shift[3], double scale);

    std::vector<FloatRing> rings_;
    RTCDevice device_ = nullptr;
    RTCScene scene_ = nullptr;
};

}  // namespace kagero

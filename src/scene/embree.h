/// The Embree scene that kernels query.
#pragma once

#include "scene/bounds.h"

#include <rtcore.h>

namespace kagero {

/// Owns a device and one committed scene; geometry identifiers are indices of surfaces.
class EmbreeScene {
public:
    /// Surfaces in coordinates relative to `space.center`; Embree's are (q − shift)·scale. Throws RunError when Embree refuses.
    EmbreeScene(const std::vector<Surface>& surfaces, const std::vector<std::size_t>& vertex_counts,
                const std::vector<std::size_t>& triangle_counts, const double shift[3], double scale);
    ~EmbreeScene();
    EmbreeScene(const EmbreeScene&) = delete;
    EmbreeScene& operator=(const EmbreeScene&) = delete;

    RTCScene scene() const { return scene_; }

private:
    RTCDevice device_ = nullptr;
    RTCScene scene_ = nullptr;
};

}  // namespace kagero

/// What a map of the sky contains for one direction of view.
#pragma once

#include "view/sky/sky_ends.h"

#include <limits>

namespace kagero {

/// The interpolated end of a ray.
struct MapEnd {
    std::array<float, 3> direction{};  ///< Direction on the sky; its length is about 1.
    SkyEnd::Kind kind = SkyEnd::Kind::other;
    /// Estimated error of the direction in radians; infinity if the ray must be traced.
    float error = std::numeric_limits<float>::infinity();
    /// Angle on the sky per length in the plane at distance 1 in front of the camera.
    float magnification = 0.5f;
};

/// Returns one magnification for both axes of a pixel. If they differ strongly, the sky is filtered with a compromise.
inline float mean_magnification(float first, float second) {
    constexpr float anisotropy = 4;
    return std::max(std::min(first, second), std::max(first, second) / anisotropy);
}

}  // namespace kagero

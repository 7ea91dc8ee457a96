/// Bounding boxes.
#pragma once

#include "scene/vector3.h"

#include <algorithm>
#include <limits>

namespace kagero {

/// Axis-aligned bounding box, initially empty.
struct Bounds {
    Double3 lower, upper;  ///< Minimum and maximum of each coordinate; ∞ and −∞ if the box is empty.

    Bounds() {
        lower.fill(std::numeric_limits<double>::infinity());
        upper.fill(-std::numeric_limits<double>::infinity());
    }
    /// Extends the box so that it contains the sphere of the given radius around `point`.
    void extend(const Double3& point, double radius = 0) {
        for (std::size_t i = 0; i < 3; ++i) {
            lower[i] = std::min(lower[i], point[i] - radius);
            upper[i] = std::max(upper[i], point[i] + radius);
        }
    }
};

}  // namespace kagero

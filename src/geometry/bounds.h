/// An axis-parallel box around things.
#pragma once

#include "scene/vector3.h"

#include <algorithm>
#include <limits>

namespace kagero {

struct Bounds {
    Double3 lower, upper;  ///< lower > upper: empty

    Bounds() {
        lower.fill(std::numeric_limits<double>::infinity());
        upper.fill(-std::numeric_limits<double>::infinity());
    }
    void include(const Double3& point, double radius = 0) {
        for (std::size_t i = 0; i < 3; ++i) {
            lower[i] = std::min(lower[i], point[i] - radius);
            upper[i] = std::max(upper[i], point[i] + radius);
        }
    }
};

}  // namespace kagero

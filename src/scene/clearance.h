/// The clearance grid: how far a ray can go without meeting anything.
#pragma once

#include "scene/bounds.h"

namespace kagero {

/// Distances and the grid that points to them.
struct Clearance {
    std::vector<float> distance;
    ClearanceGrid grid{};
};

/// Distance from q to the nearest surface, not greater than `limit`; to the rounding of Embree's float boxes.
double distance_to_surfaces(const Geometry& geometry, const Double3& q, double limit);

/// In every cubic cell a lower bound of the distance from anywhere in it to the nearest surface, at least 0. The grid covers
/// `bounds`, slightly enlarged, with `cells` cells along its longest edge.
Clearance build_clearance(const Geometry& geometry, const Bounds& bounds, std::uint32_t cells = 64);

}  // namespace kagero

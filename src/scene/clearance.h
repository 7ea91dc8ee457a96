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

/// How the axes of a scene are stretched so that the shorter ones have half as many cells as the longest, if that takes no more than a
/// factor of 32: rays that graze the ground of a wide landscape go far before they need ask.
Double3 clearance_stretch(const Bounds& bounds);

/// In every cubic cell of stretched space a lower bound of the distance from its centre to the nearest surface, at least 0. The grid
/// covers `bounds`, slightly enlarged, with `cells` cells along its longest edge. `stretched` is the committed RTCScene in which
/// coordinates are stretched as well.
Clearance build_clearance(const Geometry& geometry, void* stretched, const Double3& stretch, const Bounds& bounds, std::uint32_t cells);

}  // namespace kagero

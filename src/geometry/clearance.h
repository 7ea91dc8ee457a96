/// The clearance grid: where a ray can go without meeting anything.
#pragma once

#include "kernels/abi.h"
#include "geometry/bounds.h"
#include "geometry/clear_boxes.h"

namespace kagero {

/// Clear boxes and the grid that points to them.
struct Clearance {
    ClearBoxes boxes;
    ClearanceGrid grid{};
};

/// The point of the triangle abc that is the nearest to q.
Double3 closest_point(const Double3& q, const Double3& a, const Double3& b, const Double3& c);

/// Distance from q to the nearest surface, not greater than `limit`; to the rounding of Embree's float boxes.
double distance_to_surfaces(const Geometry& geometry, const Double3& q, double limit);

/// How the axes of a scene are stretched so that the shorter ones have half as many cells as the longest, if that takes
/// no more than a factor of 32.
Double3 clearance_stretch(const Bounds& bounds);

/// The grid covers `bounds`, slightly enlarged, with `cells` cells along the longest edge of the stretched space in
/// which they are cubes. `stretched` is the committed RTCScene in which coordinates are stretched as well: its point
/// queries tell how far surfaces are.
Clearance build_clearance(const Geometry& geometry, void* stretched, const Double3& stretch, const Bounds& bounds,
                          std::uint32_t cells);

}  // namespace kagero

/// Construction of the clearance grid, with which the kernels leave out queries that cannot find a hit.
#pragma once

#include "kernels/abi.h"
#include "geometry/clearance/bounds.h"
#include "geometry/clearance/clear_boxes.h"

#include <optional>

namespace kagero {

/// Clear boxes of a scene, and the grid that assigns a clear box to each cell. `grid` points into `boxes`.
struct Clearance {
    ClearBoxes boxes;
    ClearanceGrid grid{};
};

/// Returns the point of the triangle abc that is closest to q.
Double3 closest_point(const Double3& q, const Double3& a, const Double3& b, const Double3& c);

/// A part of a surface: its triangles first … last. A sphere has the triangle 0 only.
struct Face {
    std::uint32_t surface, first, last;
    bool operator==(const Face&) const = default;
    bool contains(std::uint32_t other_surface, std::uint32_t triangle) const {
        return surface == other_surface && first <= triangle && triangle <= last;
    }
};

/// Returns the distance from q to the nearest surface, or `limit` if that is smaller. The error is the rounding error
/// of Embree's single-precision bounding boxes.
double distance_to_surfaces(const Geometry& geometry, const Double3& q, double limit);

/// Returns the factors, from 1 to 32, by which the axes of a scene are stretched before it is divided into cubic cells.
/// Each shorter axis then has at least half as many cells as the longest one, unless the limit of 32 prevents it.
Double3 clearance_stretch(const Bounds& bounds);

/// Builds the clearance grid over `bounds`, enlarged by a margin of 1/1024 of the longest stretched edge. The cells are
/// cubes after the axes are multiplied by `stretch`, and there are `cells` of them along the longest axis.
/// `stretched_scene` is a committed RTCScene whose coordinates are multiplied by `stretch`; it is used for point
/// queries.
Clearance build_clearance(const Geometry& geometry, void* stretched_scene, const Double3& stretch,
                          const Bounds& bounds, std::uint32_t cells);

}  // namespace kagero

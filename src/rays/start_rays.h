/// Conversion of rays from positions and directions to ray starts.
#pragma once

#include "plan/plan.h"

namespace kagero {

/// Position and direction at the start of a ray, in the coordinates of the scene file. The direction may have any
/// length.
struct RayInput {
    Double3 position, direction;
};

/// Positions and directions of rays in memory that the caller owns. Three consecutive numbers are one vector. A stride
/// is the number of doubles from one ray to the next; 0: all rays have the same vector.
struct RayArrays {
    const double* positions;
    const double* directions;
    std::size_t count;
    std::size_t position_stride = 3, direction_stride = 3;

    RayInput operator[](std::size_t i) const {
        const double *q = positions + i * position_stride, *d = directions + i * direction_stride;
        return {{q[0], q[1], q[2]}, {d[0], d[1], d[2]}};
    }
};

/// Writes the starts of the rays first … last − 1 to `starts`, which has an element for each of these rays. See
/// start_rays.
void write_starts(const Plan& plan, const RayArrays& rays, std::optional<ObserverKind> observer, std::size_t first,
                  std::size_t last, RayStart* starts);

/// Returns the starts of rays. If an observer is given, the directions are those in its rest frame; otherwise, they are
/// directions of dq/dλ. For a falling observer, the plan must have been made with `falling` as Options::observer. If a
/// ray cannot start, RayStart::failure is the reason.
std::vector<RayStart> start_rays(const Plan& plan, const std::vector<RayInput>& rays,
                                 std::optional<ObserverKind> observer = {});

}  // namespace kagero

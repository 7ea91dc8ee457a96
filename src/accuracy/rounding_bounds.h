/// What rounding can do to the ends of rays.
#pragma once

#include "render/run.h"

namespace kagero {

/// Of the rays of a tile, in the order of their ends: the most by which the roundings on the way can have moved what is
/// seen there, in pixels; zero for rays that are captured, not a number where a ray ends in no place or, traced again,
/// in another way.
///
/// To first order, and if all roundings worked together: the sum of |adjoint · half a unit in the last place| over the
/// operations of every step, the adjoints by a reverse sweep along the ray (Iri 1988). What roundings do is less by
/// about the root of their number. They are those of the plan's precision and method, from the ray's start as it is,
/// which is rounded, as the end is. Told to give up, it returns at once.
std::vector<double> rounding_bounds(const Plan& plan, const Tile& tile, const RayEnd* ends, const RayList& list,
                                    const Halt& halt);

}  // namespace kagero

/// Bounds on the effect of rounding on ray ends.
#pragma once

#include "render/run.h"

namespace kagero {

/// Returns, for each ray of a tile in the order of the ends, a bound on the pixel error that rounding can cause. The
/// bound is zero for captured rays. It is NaN if the status is `step_limit` or `failed`. It is also NaN if
/// the run that records the path for the bound ends with another status or on another object than `ends`.
///
/// The bound is of first order and adds the absolute values of the effects of all roundings. It is the sum of |adjoint|
/// · (half a unit in the last place of the result) over the operations of every step. The adjoints follow from a
/// reverse sweep along the ray (Iri 1988). The actual effect is usually smaller, by about the square root of the number
/// of operations. The bound applies to the plan's precision and method, and includes the rounding of the ray start and
/// the ray end. Returns early, with incomplete bounds, if `cancel` returns true.
std::vector<double> rounding_bounds(const Plan& plan, const Tile& tile, const RayEnd* ends, const RayList& list,
                                    const CancelToken& cancel);

}  // namespace kagero

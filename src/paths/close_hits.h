/// Hits on surfaces that touch each other, or nearly do (media/close_surfaces.h).
#pragma once

#include "plan/plan.h"

namespace kagero {

/// Where surfaces are close to each other, replaces the hit of a ray in a medium by that of the surface that it meets
/// first. `start` is the start of the ray's segment, in the coordinates of the medium.
void order_close_surfaces(const Plan& plan, std::uint32_t medium, const Double3& start, RayEnd& end);

}  // namespace kagero

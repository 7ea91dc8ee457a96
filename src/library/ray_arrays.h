/// Rays that are given as arrays.
#pragma once

#include "rays/start_rays.h"

namespace kagero {

/// Returns the starts of rays, which the threads of the plan compute. See start_rays.
std::vector<RayStart> start_arrays(const Plan& plan, const RayArrays& rays, std::optional<ObserverKind> observer);

}  // namespace kagero

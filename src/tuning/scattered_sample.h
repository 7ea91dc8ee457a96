/// Rays that diffuse surfaces scatter, as a part of the sample on which methods are compared.
#pragma once

#include "accuracy/ray_errors.h"
#include "render/trace.h"

namespace kagero {

/// Adds rays to a sample: for each ray whose end is on a diffuse surface, one that the surface scatters. A method that
/// is accurate for the rays of the camera may not be for these, which start elsewhere and in all directions. Only
/// surfaces in the space of the scene are considered, because the trial chooses the method of this space.
void add_scattered_rays(const Plan& plan, const RunControl& control, SampleRays& sample);

}  // namespace kagero

/// Rays at the edge of a shadow, which magnify errors most.
#pragma once

#include "accuracy/sample_rays.h"

#include <functional>

namespace kagero {

/// A function that returns the ends of rays.
using TraceRays = std::function<std::vector<RayEnd>(const std::vector<RayStart>&)>;

/// Returns points of the film close to the edge of a shadow: the region of captured rays. `ends` are the ends of the
/// rays through the grid `sample`. Between some neighbouring rays of which one is captured, the edge is enclosed by
/// bisection, and the points whose rays are not captured are returned. There are none if no ray is captured.
std::vector<std::array<double, 2>> points_at_shadow_edge(const Plan& plan, const SampleRays& sample,
                                                         const std::vector<RayEnd>& ends, const TraceRays& trace);

}  // namespace kagero

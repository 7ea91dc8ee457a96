/// Tracing of lists of rays.
#pragma once

#include "render/run.h"

namespace kagero {

/// Traces the rays; ends[i] belongs to starts[i]. Positions in `ends` are in scene coordinates. If the run is
/// interrupted, rays that were not traced get the status `failed` and the failure `untraced`.
RunReport trace(const Plan& plan, const std::vector<RayStart>& starts, std::vector<RayEnd>& ends,
                const RunControl& control = {});

/// Traces the rays and calls `visit` for every step of every ray, from several threads, one at a time. The points are
/// in the coordinates of the Hamiltonian.
RunReport trace_steps(const Plan& plan, const std::vector<RayStart>& starts, std::vector<RayEnd>& ends,
                      const std::function<void(const PathPoint&)>& visit, const RunControl& control = {});

/// Traces the rays and returns every step of every ray, in order of ray and step, in scene coordinates.
std::vector<PathPoint> trace_paths(const Plan& plan, const std::vector<RayStart>& starts, std::vector<RayEnd>& ends,
                                   const RunControl& control = {});

}  // namespace kagero

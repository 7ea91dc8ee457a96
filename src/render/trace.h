/// Traces lists of rays.
#pragma once

#include "render/run.h"

namespace kagero {

/// ends[i] belongs to starts[i]. Positions in `ends` are scene coordinates. Rays that an early end leaves out are
/// `failed` as untraced.
RunReport trace(const Plan& plan, const std::vector<RayStart>& starts, std::vector<RayEnd>& ends,
                const Watch& watch = {});

/// The same, and calls `visit` for every step of every ray: from several threads, one at a time, in the coordinates of
/// the Hamiltonian.
RunReport trace_steps(const Plan& plan, const std::vector<RayStart>& starts, std::vector<RayEnd>& ends,
                      const std::function<void(const PathPoint&)>& visit, const Watch& watch = {});

/// Every step of every ray, in order of ray and step, in scene coordinates.
std::vector<PathPoint> trace_paths(const Plan& plan, const std::vector<RayStart>& starts, std::vector<RayEnd>& ends,
                                   const Watch& watch = {});

}  // namespace kagero

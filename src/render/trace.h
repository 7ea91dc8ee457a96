/// Tracing of lists of rays.
#pragma once

#include "render/run.h"

namespace kagero {

/// Traces the rays; ends[i] belongs to starts[i]. Positions and λ in `ends` are in the coordinates and units of the
/// scene file. If the run is interrupted, rays that were not traced get the status `failed` and the failure `untraced`.
/// At surfaces that send light on, rays take the stronger branch, up to RunConfig::max_bounces. `paths`, if not null,
/// receives the state of each ray's path.
RunReport trace(const Plan& plan, const std::vector<RayStart>& starts, std::vector<RayEnd>& ends,
                const RunControl& control = {}, std::vector<PathState>* paths = nullptr);

/// Traces the rays and calls `visit` at the start of every ray that can be traced and after every step, from several
/// threads but one at a time. PathPoint::ray is an index of `starts`. Positions and λ of the points are in the
/// coordinates and units of the kernels.
RunReport trace_steps(const Plan& plan, const std::vector<RayStart>& starts, std::vector<RayEnd>& ends,
                      const std::function<void(const PathPoint&)>& visit, const RunControl& control = {});

/// Throws InputError if RunConfig::path_interval is so short that the points of the paths of `batch` consecutive rays
/// cannot be kept in memory. The lengths of the paths are found by tracing the rays without their points. Returns false
/// if this was interrupted.
bool check_path_points(Plan plan, const std::vector<RayStart>& starts, std::size_t batch,
                       const RunControl& control = {});

/// Traces the rays and returns their starts and the points after every step, sorted by ray and step, in the coordinates
/// and units of the scene file. Rays that were not traced have no points.
std::vector<PathPoint> trace_paths(const Plan& plan, const std::vector<RayStart>& starts, std::vector<RayEnd>& ends,
                                   const RunControl& control = {});

}  // namespace kagero

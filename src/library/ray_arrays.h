/// Rays that are given as arrays.
#pragma once

#include "rays/start_rays.h"
#include "render/trace.h"

#include <functional>

namespace kagero {

/// Returns the starts of rays, which the threads of the plan compute. See start_rays.
std::vector<RayStart> start_arrays(const Plan& plan, const RayArrays& rays, std::optional<ObserverKind> observer);

/// Receives the ends of consecutive rays, of which the first has the index `first`, and their paths if they are
/// requested.
using TakeEnds =
    std::function<void(const std::vector<RayEnd>& ends, const std::vector<PathState>& paths, std::size_t first)>;

/// Traces rays in batches, so that the memory for starts and ends is that of one batch. `take` receives the batches in
/// their order. The report is that of all rays. If the run is interrupted, the other rays have the failure `untraced`.
RunReport trace_arrays(const Plan& plan, const RayArrays& rays, std::optional<ObserverKind> observer, bool with_paths,
                       const RunControl& control, const TakeEnds& take);

}  // namespace kagero

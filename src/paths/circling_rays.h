/// Rays that circle a hole so often that a method whose steps are lengths cannot follow them to their end.
#pragma once

#include "paths/trace_tile.h"
#include "plan/plan.h"

namespace kagero {

/// Traces those rays of a list again that have reached RunConfig::max_steps, with the method of Plan::circling_run,
/// whose steps are angles. Replaces the end of a ray if the second try follows it to its end; steps, gradients and
/// queries are the sums of both tries. `first` is the start of the ray that belongs to ends[0]. Does nothing if the
/// plan has no such method, if the job ends rays at a value of λ, or if it reports the points of paths. Rays that may
/// continue at surfaces are not traced again (trace_paths.h).
void retrace_circling_rays(const Plan& plan, const Job& job, const RayStart* first, std::vector<RayEnd>& ends,
                           Counters& counters);

}  // namespace kagero

/// Traces of the same rays through a scene for several sets of parameters.
#pragma once

#include "library/scene_plans.h"
#include "rays/start_rays.h"
#include "render/trace.h"
#include "sweep/sweep.h"

namespace kagero {

/// The ends of all rays for one set of parameters.
struct SweptSet {
    std::shared_ptr<const Plan> plan;
    std::vector<RayEnd> ends;
    std::vector<PathState> paths;  ///< Empty unless rays continue at surfaces.
    RunReport report;
    std::vector<std::string> remarks;  ///< See SweepResult::remarks.
};

/// Traces the rays for every set of numbers, as `sweep` does: rays of different sets share packets where this is
/// possible. The report counts the rays of all sets.
std::pair<SweepResult, RunReport> sweep_numbers(const ScenePlans& scene, const std::vector<SweptKey>& keys,
                                                const RayArrays& rays, const RayRequest& request,
                                                const RunOptions& options, const RunControl& control);

/// Traces the rays once for each set. A set consists of overrides, "key.path=value". If the run is interrupted, the
/// result contains only the sets that were begun. Progress covers all sets. Throws InputError if a set is invalid,
/// before any ray is traced.
std::vector<SweptSet> trace_sweep(const ScenePlans& scene, const std::vector<std::vector<std::string>>& sets,
                                  const RayArrays& rays, const RayRequest& request, const RunOptions& options,
                                  const RunControl& control);

}  // namespace kagero

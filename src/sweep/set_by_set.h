/// Tracing of sweeps of parameters set by set, with packets whose rays all belong to one set.
#pragma once

#include "render/run_report.h"
#include "sweep/ends_of_sets.h"
#include "sweep/scene_of_sets.h"

namespace kagero {

/// Traces the rays of the given sets, with the kernel and the method of `base`. Returns false if the run is
/// interrupted.
bool trace_set_by_set(const Plan& base, const ParameterSets& sets, const std::vector<std::size_t>& traced_sets,
                      const std::vector<RayInput>& rays, std::optional<ObserverKind> observer,
                      const RunControl& control, const EndsOfSets& ends);

}  // namespace kagero

/// Tracing of sweeps of parameters, with rays of different sets in the lanes of a packet.
#pragma once

#include "render/run_report.h"
#include "sweep/scene_of_sets.h"

namespace kagero {

/// Returns the reason why the rays of different sets cannot share packets; empty if they can. `base` is the plan of a
/// set whose rays bend, or of any set if all rays are straight.
std::string reason_against_packets(const Plan& base);

/// Traces the rays of all sets; element set · rays + ray of `ends` belongs to that set and ray. Sets whose rays are
/// straight are traced in closed form, set by set. Returns false if the run is interrupted.
bool trace_in_packets(const Plan& base, const ParameterSets& sets, const std::vector<RayInput>& rays,
                      std::optional<ObserverKind> observer, const RunControl& control, std::vector<RayEnd>& ends);

}  // namespace kagero

/// Parameter sweeps: the same rays for many values of the keys of a scene.
#pragma once

#include "rays/start_rays.h"
#include "render/run_report.h"
#include "sweep/parameter_sets.h"

#include <functional>
#include <string>
#include <vector>

namespace kagero {

/// Makes the plan of a scene with further overrides "key.path=value".
using PlanWithOverrides = std::function<Plan(const std::vector<std::string>& overrides)>;

/// The ends of the rays of a sweep.
struct SweepResult {
    std::vector<RayEnd> ends;  ///< As trace() returns them. Element set · rays + ray belongs to that set and ray.
    Plan plan;                 ///< The plan of one of the sets. For why_failed, it can represent the others.
    /// Reason why packets contain only rays of one set, which takes longer. Empty if their lanes contain rays of
    /// different sets.
    std::string reason_against_packets;
    bool interrupted = false;  ///< True if rays were not traced; their failure is `untraced`.
};

/// Traces the same rays for every set. Set i consists of value i of every key. The ends are those of one trace per set,
/// within the tolerance of the method. Sweeps of parameters of the space load the scene once. If the method is an
/// explicit Runge–Kutta method with step control, as by default, the lanes of a packet then contain rays of different
/// sets, and a ray costs hardly more than without a sweep. For other keys, and for formulas, each set has a plan of its
/// own. `plan_with` must make plans for ray lists with the observer `observer`, which has the same meaning as for
/// start_rays. Throws InputError if a key is unknown, if a value is not legal, or if the keys have different numbers of
/// values.
SweepResult sweep(const PlanWithOverrides& plan_with, const std::vector<SweptKey>& keys,
                  const std::vector<RayInput>& rays, std::optional<ObserverKind> observer = {},
                  const RunControl& control = {});

}  // namespace kagero

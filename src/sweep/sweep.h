/// Parameter sweeps: the same rays for many values of the keys of a scene.
#pragma once

#include "rays/start_rays.h"
#include "render/run_report.h"
#include "sweep/packet_sweep.h"

#include <functional>
#include <string>
#include <vector>

namespace kagero {

/// Makes the plan of a scene with further overrides "key.path=value".
using PlanWithOverrides = std::function<Plan(const std::vector<std::string>& overrides)>;

/// Reads a scene with further overrides "key.path=value".
using SceneWithOverrides = std::function<SceneDescription(const std::vector<std::string>& overrides)>;

/// Reads the scene of every set, so that a value that is not legal is found before a ray is traced. Throws InputError.
void check_scenes_of_sets(const SceneWithOverrides& scene_with, const std::vector<SweptKey>& keys);

/// The ends of the rays of a sweep.
struct SweepResult {
    std::vector<RayEnd> ends;  ///< As trace() returns them. Element set · rays + ray belongs to that set and ray.
    Plan plan;                 ///< The plan of one of the sets. For why_failed, it can represent the others.
    /// Reason why packets contain only rays of one set, which takes longer. Empty if their lanes contain rays of
    /// different sets.
    std::string reason_against_packets;
    std::vector<std::string> remarks;  ///< Statements about keys that have no effect, see unread_keys.h.
    bool interrupted = false;  ///< True if rays were not traced; their failure is `untraced`.
};

/// A sweep whose sets are prepared once, so that ranges of its sets and rays can be traced separately.
class Sweep {
public:
    /// `rays` is the number of rays of the whole sweep. For the other arguments and the exceptions, see sweep().
    Sweep(PlanWithOverrides plan_with, std::vector<SweptKey> keys, std::size_t rays,
          std::optional<ObserverKind> observer);

    std::size_t sets() const { return keys_.front().count(); }
    /// See SweepResult::plan.
    const Plan& plan() const { return plan_; }
    /// See SweepResult::reason_against_packets.
    const std::string& reason_against_packets() const { return reason_; }
    /// See SweepResult::remarks.
    const std::vector<std::string>& remarks() const { return remarks_; }
    /// Returns true if each set needs a plan of its own, so that it is traced most quickly with all its rays at once.
    bool has_separate_plans() const { return !parameters_; }
    /// Traces rays for the sets of a range. The ends do not depend on the range, and not on the other rays. If each set
    /// has a plan of its own, `plans` receives those of the range, unless it is null; otherwise, plan() describes all
    /// sets. Returns false if the run is interrupted.
    bool trace(const SetRange& range, const std::vector<RayInput>& rays, const RunControl& control,
               std::vector<RayEnd>& ends, std::vector<Plan>* plans = nullptr) const;

private:
    void prepare_parameters();
    void prepare_formula();
    bool trace_separately(const std::vector<RayInput>& rays, const RunControl& control, const EndsOfSets& ends,
                          std::vector<Plan>* plans) const;

    PlanWithOverrides plan_with_;
    std::vector<SweptKey> keys_;
    std::optional<ObserverKind> observer_;
    Plan plan_;
    Plan plan_of_packets_;  ///< `plan_`, or that of the formula with parameters in place of the swept constants.
    std::string reason_;
    std::vector<std::string> remarks_;
    std::optional<ParameterSets> parameters_;  ///< Empty if each set has a plan of its own.
    DividedSets divided_;                      ///< The sets whose rays share packets; empty if they do not.
};

/// Traces the same rays for every set. Set i consists of value i of every key. The ends are those of one trace per set,
/// within the tolerance of the method. Sweeps of parameters of the space load the scene once. If the method is an
/// explicit Runge–Kutta method with step control, as by default, the lanes of a packet then contain rays of different
/// sets, and a ray costs hardly more than without a sweep. The same holds for the constants of a formula. For other
/// keys, each set has a plan of its own. `plan_with` must make plans for ray lists with the observer `observer`, which
/// has the same meaning as for start_rays. Throws InputError if a key is unknown, if a value is not legal, or if the
/// keys have different numbers of values.
SweepResult sweep(const PlanWithOverrides& plan_with, const std::vector<SweptKey>& keys,
                  const std::vector<RayInput>& rays, std::optional<ObserverKind> observer = {},
                  const RunControl& control = {});

}  // namespace kagero

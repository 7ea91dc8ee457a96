/// Tracing of sweeps of parameters, with rays of different sets in the lanes of a packet.
#pragma once

#include "render/run_report.h"
#include "sweep/ends_of_sets.h"
#include "sweep/scene_of_sets.h"

namespace kagero {

/// Returns the reason why the rays of different sets cannot share packets; empty if they can. `base` is the plan of a
/// set whose rays bend, or of any set if all rays are straight.
std::string reason_against_packets(const Plan& base);

/// The properties of a set that all sets of one call of the kernel share, because they decide which events exist.
struct SetKind {
    bool changes_charts = false, changes_charts_at_turns = false, has_second_sheet = false;
    bool operator==(const SetKind&) const = default;
};

/// Sets of one kind whose rays bend.
struct SetGroup {
    SetKind kind;
    std::vector<std::size_t> members;             ///< Indices of the sets.
    double chart_radius = 0, bending_radius = 0;  ///< The greatest of all members.
};

/// All sets of a sweep.
struct DividedSets {
    std::vector<SetGroup> groups;       ///< The sets whose rays bend.
    std::vector<std::size_t> straight;  ///< The sets whose rays are straight.
    double first_step = 0;              ///< ParameterSets::first_step.
};

/// Divides the sets into groups. `base` is as for reason_against_packets.
DividedSets divide_sets(const Plan& base, const ParameterSets& sets, std::optional<ObserverKind> observer);

/// Traces the rays of the sets in the range of `ends`. `divided` contains all sets of the sweep, so that the ends do
/// not depend on the range. Sets whose rays are straight are traced in closed form, set by set. Returns false if the
/// run is interrupted.
bool trace_in_packets(const Plan& base, const ParameterSets& sets, const DividedSets& divided,
                      const std::vector<RayInput>& rays, std::optional<ObserverKind> observer,
                      const RunControl& control, const EndsOfSets& ends);

}  // namespace kagero

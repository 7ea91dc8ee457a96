/// Sweeps whose keys are constants of a formula: the constants become parameters, which differ from lane to lane.
#pragma once

#include "sweep/parameter_sets.h"

#include <string>
#include <vector>

namespace kagero {

/// The plan of a formula in which parameters replace constants.
struct ParameterPlan {
    Plan plan;            ///< Its scene has no paints and no sky. Empty if there is a refusal.
    std::string refusal;  ///< Reason why each set needs a plan of its own; empty if there is none.
};

/// Returns the plan of a formula in which parameters replace the constants that the keys set. Throws InputError if the
/// values of a set are not legal.
ParameterPlan plan_with_parameters(const Plan& plan, const std::vector<SweptKey>& keys, const ParameterSets& sets);

}  // namespace kagero

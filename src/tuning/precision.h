/// Float or double, where the options leave it open.
#pragma once

#include "plan/plan.h"

namespace kagero {

/// The plan in float, which has twice as many lanes, where the picture would not show it: a sparse grid of the film's
/// rays is traced in both precisions by the plan's method and step. Where anything speaks for double the plan stays as
/// it is. Plan::precision_trial and the decisions record the result.
Plan choose_precision(Plan plan);

}  // namespace kagero

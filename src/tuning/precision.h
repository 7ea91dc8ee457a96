/// Float or double, where the options leave it open.
#pragma once

#include "plan/plan.h"

namespace kagero {

/// Makes the plan follow float, which has twice as many lanes, where the picture would not show it: a sparse grid of the film's rays is
/// followed in both precisions by the plan's method and step. What came of it is Plan::float_trial; where anything speaks for double
/// the plan stays as it was.
void choose_precision(Plan& plan);

}  // namespace kagero

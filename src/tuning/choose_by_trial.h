/// The choices that trial rays of one picture make.
#pragma once

#include "plan/plan.h"
#include "render/run_report.h"

namespace kagero {

/// Returns the plan of a picture with the choices that trial rays make: method and step, unless the scene states a step
/// or tolerance and no bound on the error, and the precision.
Plan choose_by_trial(Plan plan, const RunControl& trial_control = {});

}  // namespace kagero

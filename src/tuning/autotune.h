/// A method and a step for the error that a scene allows, `integrator.max_pixel_error`.
#pragma once

#include "plan/plan.h"
#include "render/run_report.h"

namespace kagero {

/// Traces a sparse grid of the film's rays by a handful of methods, in double and (where the options leave it open)
/// float. Returns the plan by the one that keeps 99 % of them within the bound with the fewest floating-point
/// operations, two in float for one in double. A method that the scene states is kept; strategy and lanes are those
/// asked for. Where none is within the bound, the plan stays as it is. Plan::method_trial and the decisions record the
/// result. The choice does not depend on how fast the machine is, unless the time is limited: then it is among what was
/// tried within so many seconds.
Plan autotune(Plan plan, const Progress& progress = {}, double time_limit = std::numeric_limits<double>::infinity());

}  // namespace kagero

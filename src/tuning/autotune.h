/// Choice of method and step for the error that a scene permits, `integrator.max_pixel_error`.
#pragma once

#include "plan/plan.h"
#include "render/run_report.h"

namespace kagero {

/// Traces a sparse grid of the film's rays with a few methods in double, and also in float if the options leave the
/// precision open. Chooses the method, step and precision with the fewest floating-point operations for which 99 % of
/// the rays have an error within the bound. Two operations in float count as one in double. A method that the scene
/// states, and the requested strategy and lanes, are kept. The plan keeps its method and step if no measurement is
/// within the bound. Plan::method_trial and the decisions record the result.
///
/// The choice does not depend on the speed of the machine, unless the time is limited: only measurements that are
/// complete after `time_limit` seconds are considered.
Plan autotune(Plan plan, const Progress& progress = {}, double time_limit = std::numeric_limits<double>::infinity());

}  // namespace kagero

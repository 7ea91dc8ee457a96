/// Step bound for a formula that states no length_scale.
#pragma once

#include "plan/plan.h"
#include "render/run_report.h"

namespace kagero {

/// Sets RunConfig::max_step_length for a formula that states no length_scale and is integrated with step control. A
/// method with step control passes over a feature that is narrower than its steps. Therefore rays are traced with
/// bounds that decrease from infinity to a small fraction of the escape radius. The result is the greatest bound whose
/// ray ends agree with those of the smallest bound. The rays are a grid of the film's rays and, for a ray list, also
/// rays through the region of the camera; the rays of the list have no influence. Plan::trial_operations counts the
/// operations. Returns the plan unchanged for all other spaces. Throws Interrupted if `control.stop` is set.
Plan choose_step_bound(Plan plan, const Options& options, Purpose purpose, const RunControl& control = {});

}  // namespace kagero

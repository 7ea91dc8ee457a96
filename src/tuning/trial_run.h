/// A run of a few rays of a picture, which finds problems before or after the picture is rendered.
#pragma once

#include "plan/plan.h"
#include "render/run_report.h"

namespace kagero {

/// Traces a sparse grid of the film's rays with the plan's method and measures their energy errors.
RunReport trace_trial(Plan plan);

}  // namespace kagero

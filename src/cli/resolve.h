/// Plans for pictures, with the progress of trials and with warnings on stderr.
#pragma once

#include "cli/terminal.h"
#include "tuning/resolve.h"

namespace kagero {

/// Returns the plan that resolve() of tuning/resolve.h makes for a picture. Shows the progress of trials that take more
/// than a second, then prints the remarks of the plan and of the trial as warnings.
Plan resolve_with_progress(SceneDescription scene, const Options& options, const Terminal& terminal);
/// Does the same for a plan that make_plan returned.
Plan tune_with_progress(Plan plan, const Options& options, const Terminal& terminal);

/// Prints the remarks of a plan and of its trial as warnings.
void print_remarks(const Plan& plan, const Terminal& terminal);

}  // namespace kagero

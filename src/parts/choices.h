/// The choices of a plan that depend on rays, as texts in tile files.
#pragma once

#include "parts/tile_file.h"
#include "plan/plan.h"

namespace kagero {

/// Returns all choices of a tuned plan: the configuration of the run and the result of the trial.
Properties choices_of(const Plan& plan);

/// Returns the plan with these choices, without a trial. The plan must be that of the same scene and options before
/// tune(). Throws InputError, which names `path`, if this program does not have the method or kernel.
Plan with_choices(Plan plan, const Properties& choices, const std::string& path);

}  // namespace kagero

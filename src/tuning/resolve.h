/// Choice of a value for every option that a scene or the command line leaves at `auto`. The command line and the
/// library share these functions.
#pragma once

#include "tuning/choose_by_trial.h"
#include "tuning/choose_for_animation.h"

namespace kagero {

/// Returns the plan of a scene with a value for every `auto`. For a picture, choose_by_trial completes the plan,
/// or choose_for_animation if the scene is animated. Throws InputError if scene and options cannot be used, and
/// Interrupted if `trial_control.stop` is set during the trial.
Plan resolve(SceneDescription description, const Options& options, Purpose purpose = Purpose::picture,
             const RunControl& trial_control = {});

/// Returns the plan with a value for every `auto` that depends on rays. resolve() calls this for a plan of make_plan.
Plan tune(Plan plan, const Options& options, Purpose purpose, const RunControl& trial_control = {});

}  // namespace kagero

/// Resolution of every `auto` of a scene and its options. The command line and the library share these functions.
#pragma once

#include "plan/plan.h"
#include "render/run_report.h"

namespace kagero {

/// The progress callback and the time limit of trials.
struct TrialControl {
    Progress progress = {};
    double time_limit = std::numeric_limits<double>::infinity();  ///< Seconds.
};

/// Returns the plan of a scene with every `auto` resolved. For a picture, trial rays choose method, step and precision
/// if the scene bounds the error (max_pixel_error); otherwise they choose only the precision. Throws InputError if
/// scene and options cannot be used.
Plan resolve(SceneDescription description, const Options& options, Purpose purpose = Purpose::picture,
             const TrialControl& control = {});

/// Returns the plan of a picture with the choices that trial rays make.
Plan choose_by_trial(Plan plan, const TrialControl& control = {});

}  // namespace kagero

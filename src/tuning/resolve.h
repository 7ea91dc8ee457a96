/// The one place that resolves everything a scene and its options leave to the program.
#pragma once

#include "plan/plan.h"
#include "render/run_report.h"

namespace kagero {

/// How long trial rays may take, and how they report their progress.
struct TrialWatch {
    Progress progress = {};
    double time_limit = std::numeric_limits<double>::infinity();  ///< seconds
};

/// From a scene to a plan with every `auto` resolved. Of a picture, method, step and precision are chosen by trial rays
/// where the scene bounds the error (max_pixel_error), else the precision alone. Throws InputError for what cannot be
/// done.
Plan resolve(SceneDescription description, const Options& options, Purpose purpose = Purpose::picture,
             const TrialWatch& watch = {});

/// The decisions from trial rays alone, for a plan of a picture.
Plan tuned(Plan plan, const TrialWatch& watch = {});

}  // namespace kagero

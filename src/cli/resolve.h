/// Resolution of picture plans, with progress of trial rays and remarks on stderr.
#pragma once

#include "cli/terminal.h"
#include "tuning/resolve.h"

namespace kagero {

/// Calls resolve() of tuning/resolve.h. Shows the progress of trials that take more than a second, then prints the
/// remarks of the plan as warnings. `time_limit` bounds the trials, in seconds.
Plan resolve_with_progress(SceneDescription scene, const Options& options, const Terminal& terminal,
                           double time_limit = std::numeric_limits<double>::infinity());

}  // namespace kagero

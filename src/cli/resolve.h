/// Plans of pictures, with the progress of trial rays and the remarks shown to the user.
#pragma once

#include "cli/terminal.h"
#include "tuning/resolve.h"

namespace kagero {

/// As resolve() of tuning/resolve.h; shows the progress of trials that take long, then prints the plan's remarks as
/// warnings.
Plan resolve_watched(SceneDescription scene, const Options& options, const Terminal& terminal,
                     double time_limit = std::numeric_limits<double>::infinity());

}  // namespace kagero

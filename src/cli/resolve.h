/// Plans for pictures, with the progress of trials and with warnings on stderr.
#pragma once

#include "cli/terminal.h"
#include "tuning/resolve.h"

namespace kagero {

/// Returns the plan that resolve() of tuning/resolve.h makes for a picture. Shows the progress of trials that take more
/// than a second, then prints the remarks of the plan as warnings.
Plan resolve_with_progress(SceneDescription scene, const Options& options, const Terminal& terminal);

}  // namespace kagero

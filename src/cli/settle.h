/// What a picture's plan leaves open, settled before the eyes of the user.
#pragma once

#include "cli/terminal.h"
#include "plan/plan.h"

#include <limits>

namespace kagero {

/// See settle() of render/pilot.h; afterwards the plan's remarks are told. A pilot that takes long shows its progress.
void settle_watched(Plan& plan, const Terminal& terminal, double time_limit = std::numeric_limits<double>::infinity());

}  // namespace kagero

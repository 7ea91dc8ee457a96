/// A profile as a trace for viewers.
#pragma once

#include "study/profile.h"

#include <string>

namespace kagero {

/// Chrome's trace events: what every thread did when, tile by tile. Opens in Perfetto (ui.perfetto.dev) and speedscope.
std::string profile_trace(const Plan& plan, const Profile& profile, double write_seconds);

}  // namespace kagero

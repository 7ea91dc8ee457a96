/// The event trace of a profile, for trace viewers.
#pragma once

#include "study/profile.h"

#include <string>

namespace kagero {

/// Returns the activities of every thread over time, one event per tile and stage, in Chrome's trace event format. The
/// file opens in Perfetto (ui.perfetto.dev) and speedscope.
std::string profile_trace(const Plan& plan, const Profile& profile, double write_seconds);

}  // namespace kagero

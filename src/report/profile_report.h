/// A profile as JSON, as a trace for viewers, and as a page.
#pragma once

#include "study/profile.h"

#include <string>

namespace kagero {

std::string profile_json(const Plan& plan, const Profile& profile, double write_seconds);

/// Chrome's trace events: what every thread did when, tile by tile. Opens in Perfetto (ui.perfetto.dev) and speedscope.
std::string profile_trace(const Plan& plan, const Profile& profile, double write_seconds);

/// One self-contained HTML page.
std::string profile_page(const Plan& plan, const Profile& profile, double write_seconds);

/// A few lines for people.
std::string profile_text(const Profile& profile, double write_seconds);

}  // namespace kagero

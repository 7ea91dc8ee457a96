/// The HTML page of a profile: key figures, then the time per stage, thread and tile.
#pragma once

#include "study/profile.h"

#include <string>

namespace kagero {

/// Returns one self-contained HTML page.
std::string profile_page(const Plan& plan, const Profile& profile, double write_seconds);

/// Returns a summary of a few lines of text.
std::string profile_text(const Profile& profile, double write_seconds);

}  // namespace kagero

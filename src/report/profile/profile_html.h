/// A profile as a page: what to know first, then where the time goes, stage by stage, thread by thread, tile by tile.
#pragma once

#include "study/profile.h"

#include <string>

namespace kagero {

/// One self-contained HTML page.
std::string profile_page(const Plan& plan, const Profile& profile, double write_seconds);

/// A few lines for people.
std::string profile_text(const Profile& profile, double write_seconds);

}  // namespace kagero

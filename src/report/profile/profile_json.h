/// A profile as JSON.
#pragma once

#include "study/profile.h"

#include <string>

namespace kagero {

std::string profile_json(const Plan& plan, const Profile& profile, double write_seconds);

}  // namespace kagero

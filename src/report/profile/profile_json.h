/// The JSON report of `profile`.
#pragma once

#include "study/profile.h"

#include <string>

namespace kagero {

/// Returns the JSON of `profile`. `write_seconds` is the time for writing the picture.
std::string profile_json(const Plan& plan, const Profile& profile, double write_seconds);

}  // namespace kagero

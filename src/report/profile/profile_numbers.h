/// What the reports of a profile have in common: ratios of what was measured.
#pragma once

#include "report/text/numbers.h"
#include "report/thread_shares.h"
#include "study/profile.h"

#include <string>
#include <utility>
#include <vector>

namespace kagero {

/// Predicted and measured costs have units of their own; this many measured seconds are one predicted unit.
double seconds_per_predicted(const Profile& profile);

/// What a render and the writing of its picture consist of: names and seconds of all threads.
std::vector<std::pair<std::string, double>> stages_of(const Profile& profile, double write_seconds);

/// Seconds of all threads in the kernels.
double tracing_seconds(const Profile& profile);

}  // namespace kagero

/// Quantities that several reports of a profile derive from the measurements.
#pragma once

#include "report/text/numbers.h"
#include "report/thread_shares.h"
#include "study/profile.h"

#include <string>
#include <utility>
#include <vector>

namespace kagero {

/// Returns the sum of the measured times of all tiles divided by the sum of their predicted costs.
double seconds_per_predicted(const Profile& profile);

/// Returns the stages of a render, including the writing of the picture: names and seconds, summed over threads.
std::vector<std::pair<std::string, double>> stages_of(const Profile& profile, double write_seconds);

/// Returns the time that was spent in the kernels, in seconds, summed over threads.
double tracing_seconds(const Profile& profile);

}  // namespace kagero

/// Quantities that several reports of a profile derive from the measurements.
#pragma once

#include "report/text/numbers.h"
#include "report/thread_shares.h"
#include "study/profile.h"

#include <string>
#include <utility>
#include <vector>

namespace kagero {

/// Returns the measured seconds per unit of predicted cost, so that both costs have the same sum over all tiles.
double seconds_per_predicted(const Profile& profile);

/// Returns the stages of a render, including the writing of the picture: names and seconds, summed over threads.
std::vector<std::pair<std::string, double>> stages_of(const Profile& profile, double write_seconds);

/// Returns the seconds in the kernels, summed over threads.
double tracing_seconds(const Profile& profile);

}  // namespace kagero

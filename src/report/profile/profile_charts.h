/// The pictures of a profile, as SVG.
#pragma once

#include "study/profile.h"

#include <string>

namespace kagero {

/// Seconds of all threads, stage by stage.
std::string stages_chart(const Profile& profile, double write_seconds);

/// A lane for each thread, from the first ray to the last: tracing, shading, and nothing.
std::string threads_chart(const Profile& profile);

/// The film twice, each tile as dark as it was predicted, and measured, to be costly.
std::string tiles_map(const Profile& profile);

/// Predicted against measured cost, a mark for each tile.
std::string prediction_chart(const Profile& profile);

/// How many times as fast as one thread, with the ideal.
std::string scaling_chart(const Profile& profile);

/// Operations per second against what multiply-adds alone reach, for one thread.
std::string roofline_chart(const Profile& profile);

}  // namespace kagero

/// The charts of a profile, as SVG.
#pragma once

#include "study/profile.h"

#include <string>

namespace kagero {

/// Returns a bar chart of the stages: seconds summed over threads.
std::string stages_chart(const Profile& profile, double write_seconds);

/// Returns a timeline with one row per thread that shows prediction, tracing, shading and idle time.
std::string threads_chart(const Profile& profile);

/// Returns two maps of the film, coloured by the predicted and by the measured cost per pixel of each tile.
std::string tiles_map(const Profile& profile);

/// Returns a scatter plot of measured against predicted cost, with one mark per tile.
std::string prediction_chart(const Profile& profile);

/// Returns a line chart of the speedup over one thread against the number of threads. Two more lines show the speedup
/// of multiply-adds and the ideal speedup.
std::string scaling_chart(const Profile& profile);

/// Returns a bar chart of floating-point operations per second and thread, beside the measured peak of multiply-adds.
std::string roofline_chart(const Profile& profile);

}  // namespace kagero

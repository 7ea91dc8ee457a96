/// The error map of a report.
#pragma once

#include "study/picture_error.h"

#include <string>

namespace kagero {

/// The picture, its estimated and its true error side by side in one scale of false colours, as SVG that holds its
/// pictures.
std::string error_map_svg(const ErrorMap& map);

/// Share of the pixels, of those whose true error is known and above rounding, in which the estimate is the truth
/// within a factor.
double share_within(const ErrorMap& map, double factor);

}  // namespace kagero

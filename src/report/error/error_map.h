/// Drawing of the error map of an error study.
#pragma once

#include "study/picture_error.h"

#include <string>

namespace kagero {

/// Returns an SVG with the picture, its estimated error and its true error side by side, with embedded PNG images. Both
/// errors have the same scale of false colours.
std::string error_map_svg(const ErrorMap& map);

/// Returns the share of pixels whose estimated error is within `factor` of the true error. Counts only pixels
/// whose true error is known and above rounding (1e-10 pixel); returns 1 if there are none.
double share_within_factor(const ErrorMap& map, double factor);

}  // namespace kagero

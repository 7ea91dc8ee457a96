/// The colour of what glows.
#pragma once

#include <array>

namespace kagero {

/// Linear sRGB of a black body. Planck's law seen through the CIE 1931 observer in the fits of C. Wyman, P.-P. Sloan
/// and P. Shirley, JCGT 2(2), 2013 (their multi-lobe form). Colours that no screen can show, below some 1900 K, have
/// the channel that would be negative at 0.
std::array<double, 3> blackbody_color(double kelvin);

/// Luminance of the same, in the same units.
double blackbody_luminance(double kelvin);

}  // namespace kagero

/// Colours of black bodies.
#pragma once

#include "kernels/abi.h"

#include <array>
#include <span>

namespace kagero {

/// Returns the linear sRGB colour of a black body at a temperature in kelvin, in an arbitrary unit of radiance.
/// Planck's law is integrated with the colour matching functions of the CIE 1931 observer. Their multi-lobe fit is by
/// C. Wyman, P.-P. Sloan and P. Shirley, JCGT 2(2), 2013. Below about 1900 K the colour is outside the gamut of sRGB,
/// and the channel that would be negative is 0.
std::array<double, 3> blackbody_color(double kelvin);

/// Computes the colours of many black bodies with a kernel module, up to 64 in one call; `rgb` has one element for each
/// temperature. A temperature of 0 or less, or NaN, gives black.
void blackbody_colors(const Module& module, std::span<const double> kelvin, std::array<double, 3>* rgb);

/// Returns the luminance of a black body at a temperature in kelvin, in the unit of `blackbody_color`.
double blackbody_luminance(double kelvin);

}  // namespace kagero

#include "scene/blackbody.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

/// A bell that is wider on one side; wavelengths in nanometres.
double lobe(double wavelength, double height, double middle, double below, double above) {
    const double t = (wavelength - middle) / (wavelength < middle ? below : above);
    return height * std::exp(-0.5 * t * t);
}

/// Wyman, Sloan and Shirley (2013), table 1.
std::array<double, 3> observer(double l) {
    return {lobe(l, 1.056, 599.8, 37.9, 31.0) + lobe(l, 0.362, 442.0, 16.0, 26.7) + lobe(l, -0.065, 501.1, 20.4, 26.2),
            lobe(l, 0.821, 568.8, 46.9, 40.5) + lobe(l, 0.286, 530.9, 16.3, 31.1),
            lobe(l, 1.217, 437.0, 11.8, 36.0) + lobe(l, 0.681, 459.0, 26.0, 13.8)};
}

/// What the observer makes of light of one wavelength, but for Planck's exponential.
struct Line {
    double exponent;  ///< hc/λk, kelvin
    std::array<double, 3> weight;
};

/// The trapezoidal sum, whose ends vanish, in steps of 5 nm. hc/k = 1.438776877e7 nm K (CODATA 2018).
std::array<Line, 95> lines() {
    std::array<Line, 95> all{};
    for (std::size_t i = 0; i < all.size(); ++i) {
        const double wavelength = 360 + 5.0 * static_cast<double>(i);
        all[i] = {1.438776877e7 / wavelength, observer(wavelength)};
        for (double& weight : all[i].weight) weight *= 5 / std::pow(wavelength / 560, 5);
    }
    return all;
}

std::array<double, 3> tristimulus(double kelvin) {
    static const std::array<Line, 95> all = lines();
    std::array<double, 3> xyz{};
    for (const Line& line : all) {
        const double light = 1 / std::expm1(line.exponent / kelvin);
        for (std::size_t i = 0; i < 3; ++i) xyz[i] += light * line.weight[i];
    }
    return xyz;
}

}  // namespace

double blackbody_luminance(double kelvin) {
    return tristimulus(kelvin)[1];
}

std::array<double, 3> blackbody_color(double kelvin) {
    const auto [x, y, z] = tristimulus(kelvin);
    // XYZ to linear sRGB: IEC 61966-2-1.
    return {std::max(0.0, 3.2406 * x - 1.5372 * y - 0.4986 * z), std::max(0.0, -0.9689 * x + 1.8758 * y + 0.0415 * z),
            std::max(0.0, 0.0557 * x - 0.2040 * y + 1.0570 * z)};
}

}  // namespace kagero

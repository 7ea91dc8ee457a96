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

/// Planck's law over wavelength, but for a constant; hc/k = 1.438776877e7 nm K (CODATA 2018).
double planck(double wavelength, double kelvin) {
    return 1 / (std::pow(wavelength / 560, 5) * std::expm1(1.438776877e7 / (wavelength * kelvin)));
}

constexpr double first = 360, last = 830, step = 5;

/// The trapezoidal sum, whose ends vanish.
std::array<double, 3> tristimulus(double kelvin) {
    std::array<double, 3> xyz{};
    for (double l = first; l <= last; l += step) {
        const std::array<double, 3> seen = observer(l);
        const double light = planck(l, kelvin);
        for (std::size_t i = 0; i < 3; ++i) xyz[i] += light * seen[i] * step;
    }
    return xyz;
}

}  // namespace

std::array<double, 3> blackbody_color(double kelvin, double unit) {
    const auto [x, y, z] = tristimulus(kelvin);
    const double scale = 1 / tristimulus(unit)[1];
    // XYZ to linear sRGB: IEC 61966-2-1.
    const std::array<double, 3> rgb{3.2406 * x - 1.5372 * y - 0.4986 * z, -0.9689 * x + 1.8758 * y + 0.0415 * z,
                                    0.0557 * x - 0.2040 * y + 1.0570 * z};
    return {std::max(0.0, rgb[0] * scale), std::max(0.0, rgb[1] * scale), std::max(0.0, rgb[2] * scale)};
}

}  // namespace kagero

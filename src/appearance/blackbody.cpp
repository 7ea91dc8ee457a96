#include "appearance/blackbody.h"

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

/// The trapezoidal sum over 1/λ, whose ends vanish: in equal steps of it Planck's exponentials follow from each other,
/// four at a time. To 1e-4 of what finer steps give.
struct Spectrum {
    static constexpr std::size_t lines = 64, at_a_time = 4;
    static constexpr double first = 1.0 / 830, step = (1.0 / 360 - first) / (lines - 1);  ///< per nanometre
    std::array<std::array<double, lines>, 3> weights;  ///< what the observer makes of a line, but for the exponential

    Spectrum() {
        for (std::size_t i = 0; i < lines; ++i) {
            const double wavelength = 1 / (first + static_cast<double>(i) * step);
            const std::array<double, 3> seen = observer(wavelength);
            for (std::size_t c = 0; c < 3; ++c)
                weights[c][i] = seen[c] * step * wavelength * wavelength / std::pow(wavelength / 560, 5);
        }
    }
};

/// With m(x) = e^x − 1, m(x + d) = m(x) + m(d) (m(x) + 1). hc/k = 1.438776877e7 nm K (CODATA 2018).
std::array<double, 3> tristimulus(double kelvin) {
    static const Spectrum spectrum;
    const double exponent = 1.438776877e7 / kelvin,
                 growth = std::expm1(exponent * (Spectrum::at_a_time * Spectrum::step));
    std::array<double, Spectrum::at_a_time> m;
    for (std::size_t k = 0; k < m.size(); ++k)
        m[k] = std::expm1(exponent * (Spectrum::first + static_cast<double>(k) * Spectrum::step));
    std::array<std::array<double, Spectrum::at_a_time>, 3> sums{};
    for (std::size_t i = 0; i < Spectrum::lines; i += m.size())
        for (std::size_t k = 0; k < m.size(); ++k) {
            const double light = 1 / m[k];
            for (std::size_t c = 0; c < 3; ++c) sums[c][k] += light * spectrum.weights[c][i + k];
            m[k] += growth * (m[k] + 1);
        }
    std::array<double, 3> xyz;
    for (std::size_t c = 0; c < 3; ++c) xyz[c] = (sums[c][0] + sums[c][1]) + (sums[c][2] + sums[c][3]);
    return xyz;
}

}  // namespace

double blackbody_luminance(double kelvin) {
    return tristimulus(kelvin)[1];
}

std::array<double, 3> blackbody_color(double kelvin) {
    const auto [x, y, z] = tristimulus(kelvin);
    // XYZ to linear sRGB: IEC 61966-2-1. What sRGB has no blue or green for keeps its luminance.
    std::array<double, 3> rgb{std::max(0.0, 3.2406 * x - 1.5372 * y - 0.4986 * z),
                              std::max(0.0, -0.9689 * x + 1.8758 * y + 0.0415 * z),
                              std::max(0.0, 0.0557 * x - 0.2040 * y + 1.0570 * z)};
    const double luminance = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
    for (double& channel : rgb) channel *= luminance > 0 ? y / luminance : 0;
    return rgb;
}

}  // namespace kagero

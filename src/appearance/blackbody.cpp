#include "appearance/blackbody.h"

#include "kernels/assertion.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

/// Returns the value of a Gaussian bell with different widths below and above its middle; wavelengths are in
/// nanometres.
double lobe(double wavelength, double height, double middle, double width_below, double width_above) {
    const double t = (wavelength - middle) / (wavelength < middle ? width_below : width_above);
    return height * std::exp(-0.5 * t * t);
}

/// Returns the CIE 1931 colour matching functions for X, Y and Z at wavelength l, in nanometres: Wyman, Sloan and
/// Shirley (2013), table 1.
std::array<double, 3> color_matching(double l) {
    return {lobe(l, 1.056, 599.8, 37.9, 31.0) + lobe(l, 0.362, 442.0, 16.0, 26.7) + lobe(l, -0.065, 501.1, 20.4, 26.2),
            lobe(l, 0.821, 568.8, 46.9, 40.5) + lobe(l, 0.286, 530.9, 16.3, 31.1),
            lobe(l, 1.217, 437.0, 11.8, 36.0) + lobe(l, 0.681, 459.0, 26.0, 13.8)};
}

/// Nodes and weights of the integral over the spectrum: a trapezoidal sum over 1/λ, with the wavelength λ. The
/// integrand is negligible at both ends. The nodes are equidistant in 1/λ, so a recurrence gives Planck's exponentials
/// at groups of four nodes. The relative error, compared with a sum with more nodes, is 1e-4.
struct Spectrum {
    static constexpr std::size_t nodes = 64, group = 4;
    static constexpr double first = 1.0 / 830, step = (1.0 / 360 - first) / (nodes - 1);  ///< Values of 1/λ, in 1/nm.
    static constexpr double hc_over_k = 1.438776877e7;                                    ///< In nm K (CODATA 2018).
    std::array<std::array<double, nodes>, 3> weights;  ///< For X, Y and Z; they do not contain Planck's exponential.

    Spectrum() {
        // Planck's law contains λ⁻⁵, here with λ in units of 560 nm; dλ = λ² d(1/λ).
        for (std::size_t i = 0; i < nodes; ++i) {
            const double wavelength = 1 / (first + static_cast<double>(i) * step);
            const std::array<double, 3> matching = color_matching(wavelength);
            for (std::size_t c = 0; c < 3; ++c)
                weights[c][i] = matching[c] * step * wavelength * wavelength / std::pow(wavelength / 560, 5);
        }
    }
};

const Spectrum& spectrum_of_observer() {
    static const Spectrum spectrum;
    return spectrum;
}

/// Returns X, Y and Z of a black body. The recurrence of m(x) = e^x − 1 is m(x + d) = m(x) + m(d) (m(x) + 1).
std::array<double, 3> tristimulus(double kelvin) {
    const Spectrum& spectrum = spectrum_of_observer();
    const double exponent = Spectrum::hc_over_k / kelvin,
                 m_step = std::expm1(exponent * (Spectrum::group * Spectrum::step));
    std::array<double, Spectrum::group> m;
    for (std::size_t k = 0; k < m.size(); ++k)
        m[k] = std::expm1(exponent * (Spectrum::first + static_cast<double>(k) * Spectrum::step));
    std::array<std::array<double, Spectrum::group>, 3> sums{};
    for (std::size_t i = 0; i < Spectrum::nodes; i += m.size())
        for (std::size_t k = 0; k < m.size(); ++k) {
            const double planck = 1 / m[k];
            for (std::size_t c = 0; c < 3; ++c) sums[c][k] += planck * spectrum.weights[c][i + k];
            m[k] += m_step * (m[k] + 1);
        }
    std::array<double, 3> xyz;
    for (std::size_t c = 0; c < 3; ++c) xyz[c] = (sums[c][0] + sums[c][1]) + (sums[c][2] + sums[c][3]);
    return xyz;
}

/// Converts X, Y and Z to linear sRGB: IEC 61966-2-1. If a negative channel is set to 0, the others are scaled to keep
/// the luminance.
std::array<double, 3> srgb_of(const std::array<double, 3>& xyz) {
    const auto [x, y, z] = xyz;
    std::array<double, 3> rgb{std::max(0.0, 3.2406 * x - 1.5372 * y - 0.4986 * z),
                              std::max(0.0, -0.9689 * x + 1.8758 * y + 0.0415 * z),
                              std::max(0.0, 0.0557 * x - 0.2040 * y + 1.0570 * z)};
    const double luminance = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
    for (double& channel : rgb) channel *= luminance > 0 ? y / luminance : 0;
    return rgb;
}

}  // namespace

double blackbody_luminance(double kelvin) { return tristimulus(kelvin)[1]; }

std::array<double, 3> blackbody_color(double kelvin) { return srgb_of(tristimulus(kelvin)); }

void blackbody_colors(const Module& module, std::span<const double> kelvin, std::array<double, 3>* rgb) {
    constexpr std::size_t capacity = 64;
    KAGERO_ASSERT(kelvin.size() <= capacity);
    const Spectrum& spectrum = spectrum_of_observer();
    std::array<double, capacity> temperatures;
    std::array<std::array<double, capacity>, 3> xyz;
    temperatures.fill(1);
    for (std::size_t i = 0; i < kelvin.size(); ++i)
        if (kelvin[i] > 0) temperatures[i] = kelvin[i];
    PlanckSums sums{};
    sums.count = static_cast<std::uint32_t>((kelvin.size() + shading_lanes - 1) / shading_lanes * shading_lanes);
    sums.nodes = Spectrum::nodes;
    sums.first = Spectrum::hc_over_k * Spectrum::first;
    sums.step = Spectrum::hc_over_k * Spectrum::step;
    sums.kelvin = temperatures.data();
    for (std::size_t c = 0; c < 3; ++c) {
        sums.weights[c] = spectrum.weights[c].data();
        sums.sums[c] = xyz[c].data();
    }
    module.shading.planck_sums(&sums);
    for (std::size_t i = 0; i < kelvin.size(); ++i)
        rgb[i] = kelvin[i] > 0 ? srgb_of({xyz[0][i], xyz[1][i], xyz[2][i]}) : std::array<double, 3>{};
}

}  // namespace kagero

// Tests of the colours of black bodies: chromaticities from published tables, luminance from Planck's law, and colours
// outside the gamut of sRGB.
#include "appearance/blackbody.h"

#include "modules/modules.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace kagero::test {
namespace {

// CIE 1931 chromaticities (x, y) of black bodies (CIE 15:2004): illuminant A, and Planck's locus at 6500 K and 10000 K.
// The tolerance 4e-3 is the error of the fit to the colour matching functions of the CIE 1931 standard observer.
TEST(Blackbody, HasThePublishedChromaticities) {
    struct Row {
        double kelvin, x, y;
    };
    for (const Row& row : {Row{2856, 0.4476, 0.4074}, Row{6500, 0.3135, 0.3237}, Row{10000, 0.2807, 0.2884}}) {
        const auto [r, g, b] = blackbody_color(row.kelvin);
        const double x = 0.4124 * r + 0.3576 * g + 0.1805 * b, y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        const double z = 0.0193 * r + 0.1192 * g + 0.9505 * b;
        EXPECT_NEAR(y / blackbody_luminance(row.kelvin), 1, 1e-3);  // the matrix elements are rounded to 4 digits
        EXPECT_NEAR(x / (x + y + z), row.x, 4e-3) << row.kelvin;
        EXPECT_NEAR(y / (x + y + z), row.y, 4e-3) << row.kelvin;
    }
}

// The luminance is the integral, over the wavelength, of Planck's law times the colour matching function ȳ. The test
// evaluates the fit of ȳ that kagero uses (Wyman, Sloan and Shirley 2013, table 1), in steps of 0.01 nm. Wavelengths
// are in nm.
TEST(Blackbody, LuminanceIsTheIntegralOfPlancksLaw) {
    const auto lobe = [](double wavelength, double height, double middle, double width_below, double width_above) {
        const double t = (wavelength - middle) / (wavelength < middle ? width_below : width_above);
        return height * std::exp(-0.5 * t * t);
    };
    for (const double kelvin : {600.0, 1000.0, 3000.0, 6500.0, 2e4, 1e6}) {
        double sum = 0;
        for (int i = 0; i < 70000; ++i) {
            const double wavelength = 300 + 0.01 * i;
            const double luminous_efficiency =
                lobe(wavelength, 0.821, 568.8, 46.9, 40.5) + lobe(wavelength, 0.286, 530.9, 16.3, 31.1);
            sum += 0.01 * luminous_efficiency /
                   (std::pow(wavelength / 560, 5) * std::expm1(1.438776877e7 / (wavelength * kelvin)));
        }
        EXPECT_NEAR(blackbody_luminance(kelvin) / sum, 1, 1e-4) << kelvin;
    }
}

// Below about 1900 K the colour of a black body is outside the gamut of sRGB. The channel that would be negative is 0,
// and the luminance is preserved.
TEST(Blackbody, KeepsItsLuminanceOutsideSrgb) {
    for (const double kelvin : {500.0, 800.0, 1500.0, 1800.0}) {
        const auto [r, g, b] = blackbody_color(kelvin);
        EXPECT_NEAR((0.2126 * r + 0.7152 * g + 0.0722 * b) / blackbody_luminance(kelvin), 1, 1e-12) << kelvin;
        EXPECT_EQ(b, 0) << kelvin;
    }
}

// In the Rayleigh-Jeans limit of high temperatures, radiance is proportional to temperature, so that the colour is
// constant and bluish. At 1e8 K the deviation from the limit is below 1e-3. At 1000 K the colour has no blue.
TEST(Blackbody, IsProportionalToTemperatureInTheRayleighJeansLimit) {
    const auto color = blackbody_color(1e8), color_at_2e8 = blackbody_color(2e8);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(color_at_2e8[k] / color[k], 2, 1e-3);
    EXPECT_EQ(blackbody_color(1000)[2], 0);
    EXPECT_GT(color[2], 1.5 * color[0]);
}

}  // namespace
// The colours that the kernel module integrates for many temperatures are those for a single temperature, and do not
// depend on the others.
TEST(BlackBodies, HaveTheColorsOfSingleOnes) {
    for (const IsaInfo& isa : find_isas()) {
        if (!isa.supported) continue;
        const Module& module = load_module(isa.name);
        std::vector<double> kelvin{0, -5, std::nan(""), 20, 300, 1e9};
        for (double k = 900; kelvin.size() < 63; k *= 1.1) kelvin.push_back(k);
        std::vector<std::array<double, 3>> rgb(kelvin.size());
        blackbody_colors(module, kelvin, rgb.data());
        for (std::size_t i = 0; i < kelvin.size(); ++i) {
            const auto expected = kelvin[i] > 0 ? blackbody_color(kelvin[i]) : std::array<double, 3>{};
            std::array<double, 3> alone;
            blackbody_colors(module, std::span(&kelvin[i], 1), &alone);
            for (std::size_t c = 0; c < 3; ++c) {
                EXPECT_NEAR(rgb[i][c], expected[c], 1e-9 * expected[c]) << kelvin[i];
                EXPECT_EQ(rgb[i][c], alone[c]) << kelvin[i];
            }
        }
    }
}

}  // namespace kagero::test

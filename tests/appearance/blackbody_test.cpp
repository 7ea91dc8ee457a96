// Colours of black bodies: chromaticities of tables, Planck's law, and what sRGB does not hold.
#include "appearance/blackbody.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kagero::test {
namespace {

// Chromaticities of black bodies (CIE 15:2004): illuminant A, and Planck's locus at 6500 K and 10000 K; the fits of the
// observer are good to some thousandths.
TEST(Blackbody, HasTheColorsOfTheTables) {
    struct Row {
        double kelvin, x, y;
    };
    for (const Row& row : {Row{2856, 0.4476, 0.4074}, Row{6500, 0.3135, 0.3237}, Row{10000, 0.2807, 0.2884}}) {
        const auto [r, g, b] = blackbody_color(row.kelvin);
        const double x = 0.4124 * r + 0.3576 * g + 0.1805 * b, y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        const double z = 0.0193 * r + 0.1192 * g + 0.9505 * b;
        EXPECT_NEAR(y / blackbody_luminance(row.kelvin), 1, 1e-3);  // the matrices are rounded
        EXPECT_NEAR(x / (x + y + z), row.x, 4e-3) << row.kelvin;
        EXPECT_NEAR(y / (x + y + z), row.y, 4e-3) << row.kelvin;
    }
}

// The luminance is Planck's law times the observer's ȳ (Wyman, Sloan and Shirley 2013, table 1), here summed in steps
// of 0.01 nm.
TEST(Blackbody, SumsPlancksLaw) {
    const auto lobe = [](double l, double height, double middle, double below, double above) {
        const double t = (l - middle) / (l < middle ? below : above);
        return height * std::exp(-0.5 * t * t);
    };
    for (const double kelvin : {600.0, 1000.0, 3000.0, 6500.0, 2e4, 1e6}) {
        double sum = 0;
        for (int i = 0; i < 70000; ++i) {
            const double l = 300 + 0.01 * i;
            const double seen = lobe(l, 0.821, 568.8, 46.9, 40.5) + lobe(l, 0.286, 530.9, 16.3, 31.1);
            sum += 0.01 * seen / (std::pow(l / 560, 5) * std::expm1(1.438776877e7 / (l * kelvin)));
        }
        EXPECT_NEAR(blackbody_luminance(kelvin) / sum, 1, 1e-4) << kelvin;
    }
}

// Deep red lies outside sRGB: its luminance is kept.
TEST(Blackbody, KeepsItsLuminanceOutsideSrgb) {
    for (const double kelvin : {500.0, 800.0, 1500.0, 1800.0}) {
        const auto [r, g, b] = blackbody_color(kelvin);
        EXPECT_NEAR((0.2126 * r + 0.7152 * g + 0.0722 * b) / blackbody_luminance(kelvin), 1, 1e-12) << kelvin;
        EXPECT_EQ(b, 0) << kelvin;
    }
}

// Far up the spectrum's tail light grows with the temperature itself, and its colour stays.
TEST(Blackbody, IsRayleighAndJeansWhenVeryHot) {
    const auto one = blackbody_color(1e8), two = blackbody_color(2e8);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(two[k] / one[k], 2, 1e-3);
    EXPECT_EQ(blackbody_color(1000)[2], 0);
    EXPECT_GT(one[2], 1.5 * one[0]);
}

}  // namespace
}  // namespace kagero::test

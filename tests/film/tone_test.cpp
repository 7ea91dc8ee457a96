// Tests of exposure and tone: codes of displays against the formulas of sRGB and of the filmic curve.
#include "film/tone.h"

#include "film/film.h"
#include "film/image.h"
#include "film/read_image.h"
#include "film/write_film.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>

namespace {

using namespace kagero;

/// Returns the code of a linear component by the formula of IEC 61966-2-1.
int srgb_code_by_formula(float linear) {
    const double x = linear > 0 ? std::min<double>(linear, 1) : 0;
    return static_cast<int>(std::lround(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055)));
}

std::array<int, 3> codes_of(std::array<float, 3> rgb, const Tone& tone) {
    const std::vector<unsigned char> bytes = display_bytes(rgb.data(), 3, tone);
    return {bytes[0], bytes[1], bytes[2]};
}

/// Returns the hue of linear RGB, as the angle of its projection along the grey axis.
double hue(const std::array<double, 3>& rgb) {
    return std::atan2(std::numbers::sqrt3 * (rgb[1] - rgb[2]), 2 * rgb[0] - rgb[1] - rgb[2]);
}

double decoded(int code) {
    const double x = code / 255.0;
    return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
}

TEST(Srgb, HasTheCodesOfTheFormula) {
    // Every 997th float from 0 to 2, and the floats next to the least number of each code.
    for (std::uint32_t bits = 0; bits < std::bit_cast<std::uint32_t>(2.0f); bits += 997) {
        const float x = std::bit_cast<float>(bits);
        ASSERT_EQ(encode_srgb(x), srgb_code_by_formula(x)) << x;
    }
    for (int code = 0; code < 255; ++code) {
        std::uint32_t bits = std::bit_cast<std::uint32_t>(static_cast<float>(decoded(code)));
        while (srgb_code_by_formula(std::bit_cast<float>(bits)) == code) bits += 64;
        for (std::uint32_t near = bits - 128; near < bits + 128; ++near) {
            const float x = std::bit_cast<float>(near);
            ASSERT_EQ(encode_srgb(x), srgb_code_by_formula(x)) << x;
        }
    }
    for (const float x : {-1.0f, -0.0f, std::nanf(""), -std::numeric_limits<float>::infinity()})
        EXPECT_EQ(encode_srgb(x), 0) << x;
    EXPECT_EQ(encode_srgb(std::numeric_limits<float>::infinity()), 255);
}

TEST(Tone, ExposureMultipliesTheLightByPowersOfTwo) {
    for (const double stops : {-3.0, -0.5, 0.0, 1.0, 2.25})
        for (const float x : {0.01f, 0.1f, 0.3f}) {
            const auto codes = codes_of({x, 2 * x, 0}, {stops, ToneCurve::clip});
            EXPECT_EQ(codes[0], srgb_code_by_formula(float(x * std::pow(2, stops))));
            EXPECT_EQ(codes[1], srgb_code_by_formula(float(2 * x * std::pow(2, stops))));
            EXPECT_EQ(codes[2], 0);
        }
    EXPECT_EQ(codes_of({1, 0.5f, 0}, {max_exposure, ToneCurve::clip}), (std::array{255, 255, 0}));
    EXPECT_EQ(codes_of({1, 0.5f, 0}, {-max_exposure, ToneCurve::filmic}), (std::array{0, 0, 0}));
}

// Expected values by hand, from the fractions of the published formula:
//   f(2)    = (2 (0.30 + 0.05) + 0.004) / (2 (0.30 + 0.5) + 0.06) - 1/15          = 0.704 / 1.66 - 1/15    = 0.357430
//   f(0.36) = (0.36 (0.054 + 0.05) + 0.004) / (0.36 (0.054 + 0.5) + 0.06) - 1/15  = 0.04144 / 0.25944 - 1/15 = 0.093062
//   f(11.2) = (11.2 (1.68 + 0.05) + 0.004) / (11.2 (1.68 + 0.5) + 0.06) - 1/15    = 19.38 / 24.476 - 1/15  = 0.725129
TEST(Tone, FilmicCurveHasThePublishedValues) {
    EXPECT_NEAR(filmic_brightness(1), 0.357430 / 0.725129, 2e-6);
    EXPECT_NEAR(filmic_brightness(0.18), 0.093062 / 0.725129, 2e-6);
    EXPECT_NEAR(filmic_brightness(0), 0, 1e-15);
    EXPECT_NEAR(filmic_brightness(5.6), 1, 1e-15);
    EXPECT_EQ(filmic_brightness(1e30), 1);
    for (double light = 1e-4, before = 0; light < 5.6; light *= 1.1) {
        EXPECT_GT(filmic_brightness(light), before);
        before = filmic_brightness(light);
    }
    EXPECT_EQ(codes_of({1, 1, 1}, {0, ToneCurve::filmic}),
              (std::array{srgb_code_by_formula(0.492919f), srgb_code_by_formula(0.492919f),
                          srgb_code_by_formula(0.492919f)}));
}

TEST(Tone, FilmicKeepsTheHueAndDistinguishesWhatClipShowsWhite) {
    const std::array<double, 3> color{1.0, 0.55, 0.25};
    int last_blue = 0;
    for (const double light : {0.5, 1.0, 2.0, 3.0, 5.0}) {
        const std::array<float, 3> rgb{float(light * color[0]), float(light * color[1]), float(light * color[2])};
        const auto codes = codes_of(rgb, {0, ToneCurve::filmic});
        // Rounding to codes changes the hue by up to half a code, less than 0.01 radian for these colours.
        EXPECT_NEAR(hue({decoded(codes[0]), decoded(codes[1]), decoded(codes[2])}), hue(color), 0.02) << light;
        EXPECT_GT(codes[2], last_blue);  // brighter, and closer to white
        last_blue = codes[2];
    }
    EXPECT_EQ(codes_of({5, 5, 4}, {0, ToneCurve::clip}), codes_of({3, 3, 2}, {0, ToneCurve::clip}));
    EXPECT_NE(codes_of({5, 5, 4}, {0, ToneCurve::filmic}), codes_of({3, 3, 2}, {0, ToneCurve::filmic}));
}

TEST(Tone, ColorsWithoutPositiveFinitePeakAreClipped) {
    const float inf = std::numeric_limits<float>::infinity(), nan = std::nanf("");
    EXPECT_EQ(codes_of({inf, 0.5f, 0}, {0, ToneCurve::filmic}), codes_of({inf, 0.5f, 0}, {0, ToneCurve::clip}));
    EXPECT_EQ(codes_of({-1, -2, 0}, {0, ToneCurve::filmic}), (std::array{0, 0, 0}));
    EXPECT_EQ(codes_of({nan, nan, nan}, {0, ToneCurve::filmic}), (std::array{0, 0, 0}));
}

// Pictures for displays have the tone; files of light are the same without it.
TEST(Tone, AppliesToDisplayFormatsOnly) {
    namespace fs = std::filesystem;
    const fs::path folder = fs::temp_directory_path() / ("kagero-tone-" + std::to_string(::getpid()));
    fs::create_directories(folder);
    const auto read = [&](const std::string& extension, const Tone& tone) {
        Film film(2, 1, {"color"}, {}, tone);
        const float values[6] = {2, 1, 0.5f, 0.125f, 0.25f, 4};
        std::copy(std::begin(values), std::end(values), film.plane("color"));
        const std::string path = (folder / ("picture" + extension)).string();
        write_film(film, path, {});
        ImageReader reader(path, {});
        while (!reader.is_done()) reader.read_strip();
        return visit_texels(reader.take_image(), [](const auto& texels) {
            std::vector<float> rgb;
            for (std::size_t i = 0; i < 6; ++i) rgb.push_back(texels[i]);
            return rgb;
        });
    };
    const Tone filmic{-1, ToneCurve::filmic};
    for (const char* extension : {".exr", ".pfm", ".hdr"}) EXPECT_EQ(read(extension, filmic), read(extension, {}));
    for (const char* extension : {".png", ".jpg", ".tif", ".bmp", ".tga", ".ppm", ".webp"})
        EXPECT_NE(read(extension, filmic), read(extension, {})) << extension;
    // The brightest component of the first pixel is light 1 after the exposure.
    EXPECT_NEAR(read(".png", filmic)[0], 0.492919, 0.003);
    fs::remove_all(folder);
}

}  // namespace

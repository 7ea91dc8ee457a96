// Tests of averages over footprints on the sky: coarser copies of an image, the footprint of a ray, and the effect of
// both on a picture.
#include "appearance/footprint.h"
#include "tests/support/linear_image.h"
#include "tests/support/plan_fixture.h"
#include "appearance/pyramid.h"
#include "appearance/texture.h"
#include "scene/vector3.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <random>

namespace kagero::test {
namespace {

/// Returns an image of independent random values, uniform in [0, 1).
Image noise(int width, int height) {
    Image image{width, height,
                std::vector<float>(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height))};
    std::mt19937 random(3);
    for (float& value : image.rgb) value = float(random() % 1024) / 1024;
    return image;
}

// The mean over the sphere weights each row of an equirectangular image by the area of its latitude band.
TEST(CoarserImages, EndWithTheMeanOverTheSphere) {
    for (const auto& [width, height] : {std::pair{64, 32}, {37, 19}, {5, 1}, {1, 7}}) {
        const Image image = noise(width, height);
        const auto coarser = coarser_images(stored_image(image));
        ASSERT_EQ(coarser.back().width * coarser.back().height, 1);
        double sum = 0;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const double band =
                    std::cos(std::numbers::pi * y / height) - std::cos(std::numbers::pi * (y + 1) / height);
                sum += image.rgb[3 * static_cast<std::size_t>(y * width + x)] * band / (2 * width);
            }
        EXPECT_NEAR(coarser.back().rgb[0], sum, 1e-5) << width << "x" << height;  // rounding of float sums
    }
}

TEST(CoarserImages, AreConstantForAConstantImage) {
    Image image{33, 17, std::vector<float>(3 * 33 * 17, 0.5f)};
    for (const Image& level : coarser_images(stored_image(image)))
        for (const float value : level.rgb) EXPECT_NEAR(value, 0.5, 1e-5);
}

TEST(SkyTexture, IsTheInterpolatedImageForFootprintsSmallerThanATexel) {
    const Image image = noise(64, 32);
    const StoredImage stored = stored_image(image);
    const auto coarser = coarser_images(stored);
    const Double3 d = unit({1, -2, 0.7}), pole{0, 0, 1};
    const auto [u, v] = sky_coordinates(d, pole);
    const Footprint small{{0, 0, 0.09}, {0.05, 0, 0}};  // a texel is 0.098 radians high
    EXPECT_EQ(sky_texture_color(stored, coarser, d, pole, {}), texture_color(texels_of(image), u, v, repeat_along_u));
    EXPECT_EQ(sky_texture_color(stored, coarser, d, pole, sky_filter(stored, small)),
              texture_color(texels_of(image), u, v, repeat_along_u));
}

// The rows of the image are alternately black and white. A footprint along a row has the colour of the row, and one
// across the rows has their mean.
TEST(SkyTexture, IsTheMeanAlongTheMajorAxisOfALongFootprint) {
    Image image{256, 128, std::vector<float>(3 * 256 * 128)};
    for (std::size_t y = 0; y < 128; ++y)
        for (std::size_t i = 0; i < 3 * 256; ++i) image.rgb[3 * 256 * y + i] = y % 2 ? 1.0f : 0.0f;
    const StoredImage stored = stored_image(image);
    const auto coarser = coarser_images(stored);
    const double texel = std::numbers::pi / 128;
    const double latitude = 0.5 * texel;  // the middle of the row above the equator, y = 63
    const Double3 d{std::cos(latitude), 0, std::sin(latitude)}, pole{0, 0, 1};
    const Footprint along{{0, 8 * texel, 0}, {0, 0, texel}}, across{{0, 0, 8 * texel}, {0, texel, 0}};
    const Footprint round{{0, 8 * texel, 0}, {0, 0, 8 * texel}};
    EXPECT_NEAR(sky_texture_color(stored, coarser, d, pole, {})[0], 1, 1e-6);
    EXPECT_GT(sky_texture_color(stored, coarser, d, pole, sky_filter(stored, along))[0], 0.98);
    EXPECT_NEAR(sky_texture_color(stored, coarser, d, pole, sky_filter(stored, across))[0], 0.5, 0.02);
    EXPECT_NEAR(sky_texture_color(stored, coarser, d, pole, sky_filter(stored, round))[0], 0.5, 0.02);
}

// An image that is four times as wide as high has texels that are twice as high as wide. The columns are alternately
// black and white. A footprint that is two columns wide must have their mean.
TEST(SkyTexture, IsAveragedOverColumnsOfAWideImage) {
    Image image{256, 64, std::vector<float>(3 * 256 * 64)};
    for (std::size_t i = 0; i < image.rgb.size(); ++i) image.rgb[i] = i / 3 % 2 ? 1.0f : 0.0f;
    const StoredImage stored = stored_image(image);
    const auto coarser = coarser_images(stored);
    const double texel = 2 * std::numbers::pi / 256;
    for (const double offset : {0.0, 0.3, 0.5}) {
        const Double3 d{std::cos(offset * texel), std::sin(offset * texel), 0}, pole{0, 0, 1};
        const Footprint two{{0, 2 * texel, 0}, {0, 0, 2 * texel}};
        EXPECT_NEAR(sky_texture_color(stored, coarser, d, pole, sky_filter(stored, two))[0], 0.5, 0.02) << offset;
    }
}

// The number of probes is the major axis divided by the minor axis, limited to 1 to 16. A minor axis that is shorter
// than a texel counts as one texel.
TEST(SkyTexture, HasAsManyProbesAsTheAxisRatioOfTheFootprint) {
    const StoredImage stored = stored_image(noise(64, 32));
    const double texel = std::numbers::pi / 32;
    const auto probes = [&](double along, double across) {
        return sky_filter(stored, {{0, along * texel, 0}, {0, 0, across * texel}}).probes.count;
    };
    EXPECT_EQ(probes(0, 0), 1);
    EXPECT_EQ(probes(0.5, 0.1), 1);
    EXPECT_EQ(probes(6, 0.1), 6);
    EXPECT_EQ(probes(6, 2), 3);
    EXPECT_EQ(probes(100, 1), 16);
}

// The image has a white cap of about two degrees around the pole on a black sphere. A pixel is 0.2 degrees wide. Within
// the cap its colour must be white, although the pixel covers many texels in longitude near the pole. Outside the cap
// its colour must be black.
TEST(SphereTexture, IsSharpAtThePole) {
    Image image{2048, 1024, std::vector<float>(3 * 2048 * 1024, 0.0f)};
    std::fill_n(image.rgb.begin(), 3 * 2048 * 12, 1.0f);
    const StoredImage stored = stored_image(image);
    const auto coarser = coarser_images(stored);
    const double pixel = 0.2 * std::numbers::pi / 180, radius = 3;
    for (const double polar : {0.0, 0.003, 0.01, 0.02, 0.033}) {
        const Double3 point{radius * std::sin(polar), 0, radius * std::cos(polar)};
        EXPECT_GT(sphere_texture_color(stored, coarser, point, {radius * pixel, 0, 0}, {0, radius * pixel, 0})[0], 0.95)
            << polar;
    }
    const double outside_cap = 0.042;
    EXPECT_LT(sphere_texture_color(stored, coarser, {std::sin(outside_cap), 0, std::cos(outside_cap)}, {pixel, 0, 0},
                                   {0, pixel, 0})[0],
              0.05);
}

// The directions are a linear function of the film positions. The axes of the footprint must have the singular values
// of that function as lengths; the relative tolerance 1e-3 covers the curvature of the sphere. The footprint of one
// direction is 0.
TEST(FitFootprint, FindsTheSingularValuesOfALinearMap) {
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    std::vector<std::array<double, 2>> centers{{0.5, 0.5}, {1.5, 0.5}, {0.5, 1.5}, {1.5, 1.5}};
    for (int n = 0; n < 50; ++n) {
        const Double3 axis = unit({normal(random), normal(random), normal(random)});
        const Double3 a = unit(cross(axis, {normal(random), normal(random), normal(random)})), b = cross(axis, a);
        const double large = 1e-4, small = 2e-5, angle = normal(random);
        std::vector<Double3> directions;
        for (const auto& [x, y] : centers) {
            const double p = x * std::cos(angle) - y * std::sin(angle), q = x * std::sin(angle) + y * std::cos(angle);
            directions.push_back(unit(add(axis, add(scaled(a, large * p), scaled(b, small * q)))));
        }
        const Footprint f = fit_footprint(directions, centers);
        EXPECT_NEAR(length(f.major), large, 1e-3 * large);
        EXPECT_NEAR(length(f.minor), small, 1e-3 * small);
        EXPECT_NEAR(std::abs(dot(f.major, a)), large, 1e-3 * large);
    }
    EXPECT_EQ(length(fit_footprint({{1, 0, 0}}, {{0.5, 0.5}}).major), 0);
}

// A block of four escaped rays has the footprint that fit_footprint finds for the same directions, which are not a
// linear function of the film position here.
TEST(FootprintsOf, AreThoseOfFitFootprintForFourRays) {
    std::mt19937 random(11);
    std::normal_distribution<double> normal;
    for (int n = 0; n < 50; ++n) {
        const Double3 axis = unit({normal(random), normal(random), normal(random)});
        std::array<RayEnd, 4> ends{};
        PixelBlock block;
        std::vector<Double3> directions;
        for (std::size_t i = 0; i < 4; ++i) {
            directions.push_back(unit(add(axis, scaled({normal(random), normal(random), normal(random)}, 1e-3))));
            ends[i].status = Status::escaped;
            PixelSample& ray = block.rays.emplace_back();
            ray.end = &ends[i];
            ray.sky = {n % 2 == 1, directions.back()};
            block.film_positions.push_back({double(i % 2), double(i / 2)});
        }
        const Footprint expected = fit_footprint(directions, block.film_positions);
        const SkyFootprints found = footprints_of(block, 1);
        const Footprint& actual = n % 2 ? found.second_sheet : found.first_sheet;
        EXPECT_LT(length(n % 2 ? found.first_sheet.major : found.second_sheet.major), 1e-300);
        const double sign = dot(actual.major, expected.major) > 0 ? 1 : -1;
        EXPECT_LT(length(subtract(actual.major, scaled(expected.major, sign))), 1e-9 * length(expected.major));
        EXPECT_NEAR(length(actual.minor), length(expected.minor), 1e-9 * length(expected.major));
    }
}

// The probes of a stripe lie on a great circle. Their positions may be wrong by a quarter of a texel, which changes the
// mean by less than a quarter of the greatest difference of neighbouring texels.
TEST(SkyTexture, IsTheMeanOfProbesOnAGreatCircle) {
    Image image{512, 256, std::vector<float>(3 * 512 * 256)};
    const double texel = std::numbers::pi / 256, waves = 40;
    for (std::size_t i = 0; i < image.rgb.size(); ++i) {
        const double u = (double(i / 3 % 512) + 0.5) / 512, v = 1 - (double(i / 3 / 512) + 0.5) / 256;
        image.rgb[i] = float(0.5 + 0.25 * std::sin(waves * v) + 0.25 * std::cos(2 * std::numbers::pi * 20 * u));
    }
    const StoredImage stored = stored_image(image);
    const auto coarser = coarser_images(stored);
    const Double3 pole{0, 0, 1};
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    for (int n = 0; n < 200; ++n) {
        const Double3 d = unit({normal(random), normal(random), normal(random)});
        const Double3 along = scaled(unit(cross(d, {normal(random), normal(random), normal(random)})), 8 * texel);
        const Footprint footprint{along, scaled(unit(cross(d, along)), texel)};
        double mean = 0;
        for (int i = 0; i < 8; ++i) {
            const auto [u, v] = sky_coordinates(unit(add(d, scaled(along, (i + 0.5) / 8 - 0.5))), pole);
            mean += texture_color(texels_of(image), u, v, repeat_along_u)[0] / 8.0;
        }
        EXPECT_NEAR(sky_texture_color(stored, coarser, d, pole, sky_filter(stored, footprint))[0], mean, 0.03) << n;
    }
}

/// Returns a plan whose sky is noise, with a black hole in front of it. The file of the sky is removed after the plan
/// is made.
std::unique_ptr<Plan> plan_with_noise_sky(const Overrides& overrides, const Options& options = {}) {
    const auto path = std::filesystem::temp_directory_path() / ("kagero-noise-" + std::to_string(::getpid()) + ".exr");
    Film sky(1024, 512, {"color"});
    const Image image = noise(1024, 512);
    std::copy(image.rgb.begin(), image.rgb.end(), sky.plane("color"));
    write_film(sky, path.string(), {});
    auto plan = plan_of_text(
        "space.hamiltonian = \"schwarzschild\"\ncamera = { position = [9, 2, 3], look_at = [0, 0, 0], up = "
        "[0, 0, 1] }\nfilm.size = [41, 37]\nsky.texture = \"" +
            path.string() + "\"\n",
        overrides, options);
    std::filesystem::remove(path);
    return plan;
}

Film picture(const Plan& plan) {
    Film film = film_of(plan);
    render(plan, film);
    return film;
}

// A pixel is about ten texels wide, so that its colour is a mean over about 100 texels. It is much closer to the mean ½
// than single texels, whose standard deviation is 0.29.
TEST(FilteredSky, HasLessNoiseThanSingleTexels) {
    for (const char* rg : {"space.rg=0", "space.rg=1"}) {
        const Film film = picture(*plan_with_noise_sky({rg}));
        double sum2 = 0, n = 0;
        for (std::size_t i = 0; i < 41 * 37; ++i) {
            const float value = film.plane("color")[3 * i];
            if (value == 0) continue;  // captured by the black hole
            sum2 += (value - 0.5) * (value - 0.5);
            ++n;
        }
        EXPECT_GT(n, 1000);
        EXPECT_LT(std::sqrt(sum2 / n), 0.06) << rg;
    }
}

// The colours are bitwise equal for other numbers of threads, other strategies and crops.
TEST(FilteredSky, DoesNotDependOnThreadsStrategyOrCrop) {
    for (const char* spp : {"film.spp=1", "film.spp=3"}) {
        Options options;
        options.threads = 1;
        options.strategy = Strategy::packet;
        Film whole = picture(*plan_with_noise_sky({spp, "space.rg=1"}, options));
        options.threads = 3;
        options.strategy = Strategy::scalar;
        Film other = picture(*plan_with_noise_sky({spp, "space.rg=1"}, options));
        options.crop = {3, 5, 36, 37};
        Film part = picture(*plan_with_noise_sky({spp, "space.rg=1"}, options));
        for (std::uint32_t y = 0; y < 37; ++y)
            for (std::uint32_t x = 0; x < 41; ++x) {
                ASSERT_EQ(*whole.pixel("color", x, y), *other.pixel("color", x, y)) << x << "," << y;
                if (x < 3 || x >= 36 || y < 5) continue;
                ASSERT_EQ(*whole.pixel("color", x, y), *part.pixel("color", x - 3, y - 5)) << x << "," << y;
            }
    }
}

}  // namespace
}  // namespace kagero::test

// Averages over pieces of the sky: the pyramid of images, the piece a ray stands for, and what they do to a picture.
#include "appearance/footprint.h"
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

Image noise(int width, int height) {
    Image image{width, height,
                std::vector<float>(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height))};
    std::mt19937 random(3);
    for (float& value : image.rgb) value = float(random() % 1024) / 1024;
    return image;
}

TEST(Pyramid, EndsWithTheMeanOverTheSphere) {
    for (const auto& [width, height] : {std::pair{64, 32}, {37, 19}, {5, 1}, {1, 7}}) {
        const Image image = noise(width, height);
        const auto coarser = coarser_images(image);
        ASSERT_EQ(coarser.back().width * coarser.back().height, 1);
        double sum = 0;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const double band =
                    std::cos(std::numbers::pi * y / height) - std::cos(std::numbers::pi * (y + 1) / height);
                sum += image.rgb[3 * static_cast<std::size_t>(y * width + x)] * band / (2 * width);
            }
        EXPECT_NEAR(coarser.back().rgb[0], sum, 1e-5) << width << "x" << height;  // sums of floats
    }
}

TEST(Pyramid, KeepsAConstant) {
    Image image{33, 17, std::vector<float>(3 * 33 * 17, 0.5f)};
    for (const Image& level : coarser_images(image))
        for (const float value : level.rgb) EXPECT_NEAR(value, 0.5, 1e-5);
}

TEST(SkyTexture, SmallFootprintsSeeTheImageItself) {
    const Image image = noise(64, 32);
    const auto coarser = coarser_images(image);
    const Double3 d = unit({1, -2, 0.7}), pole{0, 0, 1};
    const auto [u, v] = sky_coordinates(d, pole);
    const Footprint small{{0, 0, 0.09}, {0.05, 0, 0}};  // a texel is 0.098
    EXPECT_EQ(sky_texture_color(image, coarser, d, pole, {}), texture_color(image, u, v, around));
    EXPECT_EQ(sky_texture_color(image, coarser, d, pole, small), texture_color(image, u, v, around));
}

// Stripes along the equator: a footprint along a stripe keeps it, one across the stripes mixes them.
TEST(SkyTexture, LongFootprintsAverageAlongTheirLength) {
    Image image{256, 128, std::vector<float>(3 * 256 * 128)};
    for (std::size_t y = 0; y < 128; ++y)
        for (std::size_t i = 0; i < 3 * 256; ++i) image.rgb[3 * 256 * y + i] = y % 2 ? 1.0f : 0.0f;
    const auto coarser = coarser_images(image);
    const double texel = std::numbers::pi / 128,
                 latitude = 0.5 * texel;  // in the middle of the row above the equator, y = 63
    const Double3 d{std::cos(latitude), 0, std::sin(latitude)}, pole{0, 0, 1};
    const Footprint along{{0, 8 * texel, 0}, {0, 0, texel}}, across{{0, 0, 8 * texel}, {0, texel, 0}};
    const Footprint round{{0, 8 * texel, 0}, {0, 0, 8 * texel}};
    EXPECT_NEAR(sky_texture_color(image, coarser, d, pole, {})[0], 1, 1e-6);
    EXPECT_GT(sky_texture_color(image, coarser, d, pole, along)[0], 0.98);
    EXPECT_NEAR(sky_texture_color(image, coarser, d, pole, across)[0], 0.5, 0.02);
    EXPECT_NEAR(sky_texture_color(image, coarser, d, pole, round)[0], 0.5, 0.02);
}

// An image four times as wide as high has texels twice as high as wide: those too are averaged.
TEST(SkyTexture, WideImagesAreAveragedAlongTheirRows) {
    Image image{256, 64, std::vector<float>(3 * 256 * 64)};
    for (std::size_t i = 0; i < image.rgb.size(); ++i) image.rgb[i] = i / 3 % 2 ? 1.0f : 0.0f;
    const auto coarser = coarser_images(image);
    const double texel = 2 * std::numbers::pi / 256;
    for (const double turn : {0.0, 0.3, 0.5}) {
        const Double3 d{std::cos(turn * texel), std::sin(turn * texel), 0}, pole{0, 0, 1};
        const Footprint two{{0, 2 * texel, 0}, {0, 0, 2 * texel}};
        EXPECT_NEAR(sky_texture_color(image, coarser, d, pole, two)[0], 0.5, 0.02) << turn;
    }
}

TEST(SkyTexture, ProbesAreAsManyAsAFootprintIsLong) {
    const Image image = noise(64, 32);
    const double texel = std::numbers::pi / 32;
    const auto probes = [&](double along, double across) {
        return sky_probes(image, {{0, along * texel, 0}, {0, 0, across * texel}});
    };
    EXPECT_EQ(probes(0, 0), 1);
    EXPECT_EQ(probes(0.5, 0.1), 1);
    EXPECT_EQ(probes(6, 0.1), 6);
    EXPECT_EQ(probes(6, 2), 3);
    EXPECT_EQ(probes(100, 1), 16);
}

// A linear map of places to directions, sampled in a block: its singular values are the axes. A cap of two degrees,
// white on black: a pixel of a fifth of a degree sees nothing else, however long the way around it is in longitude.
TEST(SphereTexture, IsAsSharpAtThePolesAsElsewhere) {
    Image image{2048, 1024, std::vector<float>(3 * 2048 * 1024, 0.0f)};
    std::fill_n(image.rgb.begin(), 3 * 2048 * 12, 1.0f);
    const auto coarser = coarser_images(image);
    const double pixel = 0.2 * std::numbers::pi / 180, radius = 3;
    for (const double polar : {0.0, 0.003, 0.01, 0.02, 0.033}) {
        const Double3 point{radius * std::sin(polar), 0, radius * std::cos(polar)};
        EXPECT_GT(sphere_texture_color(image, coarser, point, {radius * pixel, 0, 0}, {0, radius * pixel, 0})[0], 0.95)
            << polar;
    }
    const double beyond = 0.042;
    EXPECT_LT(sphere_texture_color(image, coarser, {std::sin(beyond), 0, std::cos(beyond)}, {pixel, 0, 0},
                                   {0, pixel, 0})[0],
              0.05);
}

TEST(Spread, IsThatOfALinearMap) {
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    std::vector<std::array<double, 2>> centers{{0.5, 0.5}, {1.5, 0.5}, {0.5, 1.5}, {1.5, 1.5}};
    for (int n = 0; n < 50; ++n) {
        const Double3 axis = unit({normal(random), normal(random), normal(random)});
        const Double3 a = unit(cross(axis, {normal(random), normal(random), normal(random)})), b = cross(axis, a);
        const double large = 1e-4, small = 2e-5, turn = normal(random);
        std::vector<Double3> directions;
        for (const auto& [x, y] : centers) {
            const double p = x * std::cos(turn) - y * std::sin(turn), q = x * std::sin(turn) + y * std::cos(turn);
            directions.push_back(unit(add(axis, add(scaled(a, large * p), scaled(b, small * q)))));
        }
        const Footprint f = spread_of(directions, centers);
        EXPECT_NEAR(length(f.major), large, 1e-3 * large);
        EXPECT_NEAR(length(f.minor), small, 1e-3 * small);
        EXPECT_NEAR(std::abs(dot(f.major, a)), large, 1e-3 * large);
    }
    EXPECT_EQ(length(spread_of({{1, 0, 0}}, {{0.5, 0.5}}).major), 0);
}

/// A sky of noise behind a hole or nothing, its file gone when the plan is made.
std::unique_ptr<Plan> noisy(const Overrides& overrides, const Options& options = {}) {
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

// A pixel is some ten texels wide, so its mean is that of a hundred: far nearer to ½ than the single texels, which
// spread by 0.29.
TEST(FilteredSky, DoesNotSparkle) {
    for (const char* rg : {"space.rg=0", "space.rg=1"}) {
        const Film film = picture(*noisy({rg}));
        double sum2 = 0, n = 0;
        for (std::size_t i = 0; i < 41 * 37; ++i) {
            const float value = film.plane("color")[3 * i];
            if (value == 0) continue;  // the hole
            sum2 += (value - 0.5) * (value - 0.5), ++n;
        }
        EXPECT_GT(n, 1000);
        EXPECT_LT(std::sqrt(sum2 / n), 0.06) << rg;
    }
}

TEST(FilteredSky, DependsOnNeitherTilesNorCrops) {
    for (const char* spp : {"film.spp=1", "film.spp=3"}) {
        Options options;
        options.threads = 1, options.strategy = Strategy::packet;
        Film whole = picture(*noisy({spp, "space.rg=1"}, options));
        options.threads = 3, options.strategy = Strategy::scalar;
        Film other = picture(*noisy({spp, "space.rg=1"}, options));
        options.crop = {3, 5, 36, 37};
        Film part = picture(*noisy({spp, "space.rg=1"}, options));
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

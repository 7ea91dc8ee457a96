// Tests of the directions toward lights: their densities are those of the directions that are drawn.
#include "tests/support/plan_fixture.h"

#include "appearance/lights/light_proposals.h"
#include "rays/sampler.h"
#include "scene/vector3.h"

#include <gtest/gtest.h>

#include <numbers>

namespace kagero::test {
namespace {

/// Writes a sky of luminance 1 with one texel of luminance `sun`. Row 0 is at the bottom.
std::string write_sky(int width, int height, int row, int column, float sun) {
    const auto path = std::filesystem::temp_directory_path() / ("kagero-sky-" + std::to_string(::getpid()) + ".pfm");
    std::ofstream file(path, std::ios::binary);
    file << "PF\n" << width << ' ' << height << "\n-1.0\n";
    for (int i = 0; i < width * height; ++i) {
        const float value = i == row * width + column ? sun : 1;
        for (int k = 0; k < 3; ++k) file.write(reinterpret_cast<const char*>(&value), sizeof value);
    }
    return path.string();
}

std::string scene_with_sky(const std::string& path) {
    return "[space]\nhamiltonian = \"flat\"\n[sky]\npole = [0.3, 0.2, 1]\ntexture = \"" + path +
           "\"\n[camera]\nposition = [0, 0, 3]\nlook_at = [0, 0, 0]\nup = [0, 1, 0]\n[film]\nsize = [8, 8]\n"
           "[[object]]\nname = \"ball\"\nshape = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\nmaterial = \"diffuse\"\n"
           "[[object]]\nname = \"lamp\"\nshape = \"sphere\"\ncenter = [0, 2, 2]\nradius = 0.5\ncolor = [2, 2, 2]\n";
}

/// Returns the mean of 1/density over drawn directions, divided by the solid angle in which the density is not zero: 1
/// if the density belongs to the directions. `inverse` is limited to directions whose density is positive everywhere.
TEST(LightProposals, DrawDirectionsWithTheirDensity) {
    const std::string path = write_sky(64, 32, 28, 20, 5000);
    const auto plan = plan_of_text(scene_with_sky(path), {});
    std::filesystem::remove(path);
    const LightProposals& lights = *plan->scene->lights;
    ASSERT_FALSE(lights.empty());
    LightProposals::Around around;
    ASSERT_TRUE(around.set(lights, {0, 1, 0}, {0, 0.8, 0.6}));
    constexpr std::uint32_t count = 1 << 16;
    double mean = 0, sun = 0, sun_density = 0;
    const Double3 sun_direction = [&] {  // the brightest direction
        Double3 brightest{};
        float greatest = 0;
        for (std::uint32_t i = 0; i < 1 << 16; ++i) {
            const auto [u, v] = sample_position(1, 2, i, 1 << 16, 3);
            const double z = 2 * u - 1, r = std::sqrt(1 - z * z), a = 2 * std::numbers::pi * v;
            const Double3 d{r * std::cos(a), r * std::sin(a), z};
            const float red = plan->scene->paints->sky_color(d)[0];
            if (red > greatest) {
                greatest = red;
                brightest = d;
            }
        }
        return brightest;
    }();
    for (std::uint32_t i = 0; i < count; ++i) {
        const PixelRay ray{5, 6, i, 7};
        const Double3 d = around.direction(sample_number(ray, RandomChoice::strategy, 0),
                                           sample_square(ray, RandomChoice::direction, 0));
        EXPECT_NEAR(length(d), 1, 1e-12);
        mean += 1 / around.density(d) / count / (4 * std::numbers::pi);
        sun += dot(d, sun_direction) > std::cos(0.3);
    }
    EXPECT_NEAR(mean, 1, 0.05);
    sun_density = around.density(sun_direction);
    EXPECT_GT(sun, 0.2 * count);
    EXPECT_GT(sun_density, 1);
}

}  // namespace
}  // namespace kagero::test

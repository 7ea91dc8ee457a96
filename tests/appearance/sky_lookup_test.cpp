// Tests of SkyLookup: the colours of many rays at once are those of the functions for a single ray.
#include "appearance/packets/sky_lookup.h"

#include "scene/vector3.h"
#include "tests/support/velocity_scenes.h"

#include <gtest/gtest.h>

#include <random>

namespace kagero::test {
namespace {

/// Rays that escape, in blocks of 2 × 2 pixels.
struct EscapedBlocks {
    std::vector<std::array<RayEnd, 4>> ends;
    std::vector<PixelBlock> blocks;

    /// The directions of a block are not a linear function of the film position. `size` is the size of its pixels in
    /// radians. Every fifth block is next to a pole of the sky, and every seventh on the meridian opposite to +x.
    EscapedBlocks(std::size_t count, double size, const Double3& pole, unsigned seed) : ends(count), blocks(count) {
        std::mt19937 random(seed);
        std::normal_distribution<double> normal;
        const auto any = [&] { return Double3{normal(random), normal(random), normal(random)}; };
        for (std::size_t n = 0; n < count; ++n) {
            Double3 axis = unit(any());
            if (n % 5 == 0) axis = add(scaled(unit(pole), n % 2 ? 1 : -1), scaled(any(), 2 * size));
            if (n % 7 == 0) axis = {-1, 0.2 * size * normal(random), 0.3 * normal(random)};
            const Double3 right = scaled(any(), size), below = scaled(any(), 0.3 * size);
            for (std::size_t i = 0; i < 4; ++i) {
                const Double3 moved = add(scaled(right, double(i % 2)), scaled(below, double(i / 2)));
                ends[n][i].status = Status::escaped;
                PixelSample& ray = blocks[n].rays.emplace_back();
                ray.end = &ends[n][i];
                ray.sky = {n % 3 == 0, unit(add(add(axis, moved), scaled(any(), 0.05 * size)))};
                blocks[n].film_positions.push_back({double(i % 2), double(i / 2)});
            }
        }
    }
};

const Footprint& footprint_on_sky(const SkyFootprints& footprints, const PixelSample& ray) {
    return ray.sky.on_second_sheet ? footprints.second_sheet : footprints.first_sheet;
}

/// Returns the sky with the given TOML keys, and a second sky with an image of 8 bits.
std::unique_ptr<Plan> plan_with_sky(const std::string& sky) {
    const std::string textures = KAGERO_SCENES "/textures/";
    return plan_of_text(
        "space = { hamiltonian = \"wormhole\" }\nfilm.size = [4, 4]\ncamera = { position = [9, 0, 0], "
        "look_at = [0, 0, 0] }\nsky = { " +
            sky + ", pole = [0.3, 0.2, 1], far = { texture = \"" + textures +
            "galaxy-sky.jpg\", pole = [0, 0, 1] } }\n",
        {});
}

class Skies : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(, Skies,
                         testing::Values("checker = true", "color = [0.1, 0.2, 0.3]",
                                         "texture = \"" KAGERO_SCENES "/textures/milkyway.jpg\""));

// The results of vectors of the module differ from those of single rays by rounding errors.
constexpr double rounding = 2e-6;

TEST_P(Skies, HaveTheColorsOfSingleRays) {
    if (!is_available("wormhole")) GTEST_SKIP() << "the kernel modules were built without wormhole";
    const auto plan = plan_with_sky(GetParam());
    const Paints& paints = *plan->scene->paints;
    for (const double size : {1e-4, 1e-3, 0.02, 0.3}) {  // closer to a pole, the asin of single rays is inaccurate
        EscapedBlocks escaped(203, size, {0.3, 0.2, 1}, 3);
        SkyLookup skies(plan->module(), paints, true);
        for (PixelBlock& block : escaped.blocks) skies.add_block(std::span(block.rays).first<4>());
        skies.finish();
        for (PixelBlock& block : escaped.blocks) {
            const SkyFootprints footprints = footprints_of(block, 1);
            for (const PixelSample& ray : block.rays) {
                const Footprint& expected = footprint_on_sky(footprints, ray);
                const double sign = dot(expected.major, ray.footprint.major) < 0 ? -1 : 1;
                EXPECT_LT(length(subtract(ray.footprint.major, scaled(expected.major, sign))),
                          1e-6 * length(expected.major));
                EXPECT_NEAR(length(ray.footprint.minor), length(expected.minor), 1e-6 * length(expected.major));
                const Float3 color = paints.sky_color(ray.sky.direction, ray.sky.on_second_sheet,
                                                      paints.sky_filter(ray.sky.on_second_sheet, ray.footprint));
                for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(ray.source_color[k], color[k], rounding) << size;
            }
        }
    }
}

TEST_P(Skies, HaveColorsThatDoNotDependOnTheOtherRays) {
    if (!is_available("wormhole")) GTEST_SKIP() << "the kernel modules were built without wormhole";
    const auto plan = plan_with_sky(GetParam());
    const Paints& paints = *plan->scene->paints;
    EscapedBlocks escaped(100, 2e-3, {0.3, 0.2, 1}, 4);
    SkyLookup together(plan->module(), paints, false);
    for (PixelBlock& block : escaped.blocks)
        for (PixelSample& ray : block.rays) together.add(ray, footprint_on_sky(footprints_of(block, 1), ray));
    together.finish();
    SkyLookup alone(plan->module(), paints, false);
    for (PixelBlock& block : escaped.blocks)
        for (const PixelSample& ray : block.rays) {
            PixelSample single = ray;
            single.source_color = {-1, -1, -1};
            alone.add(single, footprint_on_sky(footprints_of(block, 1), ray));
            alone.finish();
            EXPECT_EQ(single.source_color, ray.source_color);
        }
}

}  // namespace
}  // namespace kagero::test

// Tests of sky_view, which returns the sky and the direction that an escaped ray shows in a wormhole scene. The second
// sheet, whose sky is the far sky, is the ball of radius R (`radius`) in isotropic coordinates.
#include "appearance/sky_view.h"

#include "scene/vector3.h"

#include <gtest/gtest.h>

#include <random>

namespace kagero {
namespace {

constexpr double radius = 0.375;

TEST(SkyView, ShowsTheNearSkyOutsideTheThroat) {
    const Double3 d = unit({1, 2, -2});
    for (const double r : {0.3750001, 1.0, 50.0}) {
        const SkyView view = sky_view(radius, {0, r, 0}, d);
        EXPECT_FALSE(view.on_second_sheet);
        EXPECT_EQ(view.direction, d);
    }
    EXPECT_FALSE(sky_view(0, {0, 0, 0.1}, d).on_second_sheet);
}

// The direction of a radial ray is reflected: a ray that moves to the centre moves outward on the second sheet.
TEST(SkyView, ReversesTheDirectionOfARadialRayOnTheSecondSheet) {
    const SkyView view = sky_view(radius, {0, 0, 0.01}, {0, 0, -1});
    EXPECT_TRUE(view.on_second_sheet);
    EXPECT_EQ(view.direction, (Double3{0, 0, 1}));
}

// The coordinates on the second sheet are given by the inversion q R²/|q|². It maps a small displacement of q along the
// ray direction d to a displacement that is parallel to the direction that sky_view returns.
TEST(SkyView, MapsDirectionsByTheDifferentialOfTheInversion) {
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    const auto inverted = [](const Double3& q) { return scaled(q, radius * radius / dot(q, q)); };
    for (int i = 0; i < 100; ++i) {
        const Double3 d = unit({normal(random), normal(random), normal(random)});
        const Double3 q = scaled(unit({normal(random), normal(random), normal(random)}), 0.04);
        const SkyView view = sky_view(radius, q, d);
        ASSERT_TRUE(view.on_second_sheet);
        constexpr double h = 1e-7;
        const Double3 expected = unit(subtract(inverted(add(q, scaled(d, h))), inverted(subtract(q, scaled(d, h)))));
        // The central difference has a truncation error of (h/|q|)² and a rounding error of ε/(h/|q|).
        EXPECT_LE(length(subtract(expected, view.direction)), 1e-9);
    }
}

}  // namespace
}  // namespace kagero

// Through a wormhole: which universe's sky an escaped ray sees, and in which direction.
#include "appearance/sky_view.h"

#include "scene/vector3.h"

#include <gtest/gtest.h>

#include <random>

namespace kagero {
namespace {

constexpr double radius = 0.375;

TEST(SkyView, OutsideTheThroatIsTheNearSky) {
    const Double3 d = unit({1, 2, -2});
    for (const double r : {0.3750001, 1.0, 50.0}) {
        const SkyView view = sky_view(radius, {0, r, 0}, d);
        EXPECT_FALSE(view.far);
        EXPECT_EQ(view.direction, d);
    }
    EXPECT_FALSE(sky_view(0, {0, 0, 0.1}, d).far);
}

// A ray that falls straight through comes out straight.
TEST(SkyView, StraightThroughIsStraightOut) {
    const SkyView view = sky_view(radius, {0, 0, 0.01}, {0, 0, -1});
    EXPECT_TRUE(view.far);
    EXPECT_EQ(view.direction, (Double3{0, 0, 1}));
}

// The other universe's own coordinates are q R²/|q|²: a short way along d in q is one along the direction found in
// those.
TEST(SkyView, TheDirectionIsTheInversionsDifferential) {
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    const auto inverted = [](const Double3& q) { return scaled(q, radius * radius / dot(q, q)); };
    for (int i = 0; i < 100; ++i) {
        const Double3 d = unit({normal(random), normal(random), normal(random)});
        const Double3 q = scaled(unit({normal(random), normal(random), normal(random)}), 0.04);
        const SkyView view = sky_view(radius, q, d);
        ASSERT_TRUE(view.far);
        constexpr double h = 1e-7;
        const Double3 there = unit(subtract(inverted(add(q, scaled(d, h))), inverted(subtract(q, scaled(d, h)))));
        // Central difference: (h/|q|)² of the direction, and rounding over h/|q|.
        EXPECT_LE(length(subtract(there, view.direction)), 1e-9);
    }
}

}  // namespace
}  // namespace kagero

// Tests the parts of adaptive sampling: interpolation of ray ends, displacements, and the search for surfaces.
#include "adaptive/bundle.h"
#include "adaptive/displacement.h"
#include "adaptive/end_interpolant.h"
#include "geometry/clearance/bundle_part.h"
#include "scene/load/load.h"
#include "tests/support/plan_fixture.h"

#include <gtest/gtest.h>

#include <random>

namespace kagero::test {
namespace {

/// A polynomial of degree 2 in u and in v, with values in three dimensions.
Double3 biquadratic(double u, double v) {
    return {1 + u - 0.3 * v + 0.2 * u * u * v - 0.1 * u * u * v * v, 2 - u * v + 0.05 * v * v, 3 + 0.4 * u * u};
}

TEST(EndInterpolant, IsExactForBiquadraticEnds) {
    std::array<RayEnd, 9> ends{};
    EndLattice lattice;
    for (std::size_t i = 0; i < 9; ++i) {
        const Double3 q = biquadratic(double(i % 3), double(i / 3));
        std::copy(q.begin(), q.end(), ends[i].q);
        ends[i].v[0] = 1;
        ends[i].surface = 7;
        lattice[i] = &ends[i];
    }
    EndInterpolant interpolant(lattice);
    for (const double v : {0.0, 0.4, 1.5, 2.0}) {
        interpolant.set_row(v);
        for (const double u : {0.0, 0.3, 1.0, 1.9}) {
            RayEnd end;
            interpolant.write(u, end);
            const Double3 expected = biquadratic(u, v);
            for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(end.q[k], expected[k], 1e-14);
            EXPECT_EQ(end.surface, 7u);
            EXPECT_TRUE(std::isnan(end.energy_error));
        }
    }
}

TEST(Displacement, SolvesForThePositionOnThePictureWhereThePictureIsStretched) {
    // One pixel to the right is 4 units along x, and one pixel down is 3 units along x and 2 along y.
    const EndDerivatives derivatives{{4, 0, 0}, {3, 2, 0}};
    const double dx = 0.3, dy = -0.2;
    const Double3 error{4 * dx + 3 * dy, 2 * dy, 0};
    EXPECT_NEAR(displacement_in_pixels(derivatives, error, 1), std::hypot(dx, dy), 1e-12);
    // Perpendicular to both, and where the picture is magnified, the size of a pixel counts.
    EXPECT_NEAR(displacement_in_pixels(derivatives, {0, 0, 0.5}, 0.1), 5, 1e-12);
    EXPECT_NEAR(displacement_in_pixels({{1e-9, 0, 0}, {0, 1e-9, 0}}, {0.02, 0, 0}, 0.1), 0.2, 1e-12);
    EXPECT_NEAR(displacement_in_pixels({{0, 0, 0}, {0, 0, 0}}, {0.02, 0, 0}, 0.1), 0.2, 1e-12);
}

/// Returns a point of the unit cube.
Double3 random_point(std::mt19937& random) {
    std::uniform_real_distribution<double> uniform(0, 1);
    const double x = uniform(random), y = uniform(random);
    return {x, y, uniform(random)};
}

constexpr const char* two_surfaces = R"toml([space]
hamiltonian = "flat"
[camera]
position = [0, 0, 9]
look_at = [0, 0, 0]
[film]
size = [4, 4]
[[object]]
name = "square"
shape = "rectangle"
origin = [0.3, 0.3, 0.4]
edge_u = [0.3, 0.1, 0]
edge_v = [0, 0.2, 0.3]
[[object]]
name = "ball"
shape = "sphere"
center = [0.7, 0.2, 0.6]
radius = 0.1
)toml";

/// A bundle of straight rays between two parallelograms.
struct StraightPart {
    Double3 origin, u, v, along, widening;

    explicit StraightPart(std::mt19937& random)
        : origin(random_point(random)), u(scaled(random_point(random), 0.2)), v(scaled(random_point(random), 0.2)),
          along(subtract(random_point(random), random_point(random))),
          widening(scaled(subtract(random_point(random), random_point(random)), 0.1)) {}

    /// Returns the position of the ray at (a, b) of the parallelograms, at the fraction t of its length.
    Double3 at(double a, double b, double t) const {
        return add(add(origin, add(scaled(u, a), scaled(v, b))), scaled(add(along, scaled(widening, a)), t));
    }
    BundlePart part() const {
        BundlePart part{};
        constexpr double places[9][2] = {{0.5, 0.5}, {0, 0}, {0.5, 0}, {1, 0}, {0, 0.5},
                                         {1, 0.5},   {0, 1}, {0.5, 1}, {1, 1}};
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t k = 0; k < 9; ++k) part.slices[i][k] = at(places[k][0], places[k][1], 0.5 * double(i));
            for (const Double3& q : part.slices[i])
                part.radius = std::max(part.radius, length(subtract(q, part.slices[i][0])));
            part.across = part.along = part.radius;
        }
        return part;
    }
};

// Many points of the part are compared with their distances from the surfaces.
TEST(IsClear, FindsEverySurfaceInTheBundle) {
    const auto plan = plan_of_text(two_surfaces, {});
    const Geometry& geometry = *plan->scene->geometry->kernel_view();
    std::mt19937 random(7);
    std::size_t clear = 0, touching = 0;
    for (int round = 0; round < 4000; ++round) {
        const StraightPart straight(random);
        double least = 1;
        for (int i = 0; i <= 6; ++i)
            for (int k = 0; k <= 6; ++k)
                for (int l = 0; l <= 12; ++l)
                    least = std::min(least, distance_to_surfaces(geometry, straight.at(i / 6.0, k / 6.0, l / 12.0), 1));
        touching += least < 0.005;
        if (!is_clear(geometry, straight.part(), {})) continue;
        ++clear;
        EXPECT_GT(least, 1e-6) << round;
    }
    EXPECT_GT(clear, 1500u);
    EXPECT_GT(touching, 100u);
}

TEST(IsClear, LeavesOutTheIgnoredFace) {
    const auto plan = plan_of_text(two_surfaces, {});
    const Geometry& geometry = *plan->scene->geometry->kernel_view();
    BundlePart part{};
    for (BundleSlice& slice : part.slices)  // points on both sides of the square
        for (std::size_t i = 0; i < 9; ++i) slice[i] = {0.45, 0.45, 0.55 + 0.005 * double(i % 3) - 0.005};
    part.radius = part.across = part.along = 0.01;
    EXPECT_FALSE(is_clear(geometry, part, {}));
    EXPECT_TRUE(is_clear(geometry, part, plan->scene->geometry->face_of(0, 1)));
    part.radius = part.across = 0.3;  // the ball is closer
    EXPECT_FALSE(is_clear(geometry, part, plan->scene->geometry->face_of(0, 1)));
}

}  // namespace
}  // namespace kagero::test

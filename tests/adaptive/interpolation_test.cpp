// Tests the parts of adaptive sampling: interpolation of ray ends, displacements, and gaps between rays and surfaces.
#include "adaptive/bundle.h"
#include "adaptive/displacement.h"
#include "adaptive/end_interpolant.h"
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

// The gap is compared with the distances of many points of the quadrangle between the corners.
TEST(GapToSurfaces, IsALowerBoundForAllPointsOfTheSlice) {
    const auto plan = plan_of_text(two_surfaces, {});
    const Geometry& geometry = *plan->scene->geometry->kernel_view();
    std::mt19937 random(7);
    std::size_t positive = 0;
    for (int round = 0; round < 2000; ++round) {
        const Double3 origin = random_point(random), u = scaled(random_point(random), 0.2),
                      v = scaled(random_point(random), 0.2);
        const auto at = [&](double a, double b) { return add(origin, add(scaled(u, a), scaled(v, b))); };
        BundleSlice slice{{at(0.5, 0.5), at(0, 0), at(0.5, 0), at(1, 0), at(0, 0.5), at(1, 0.5), at(0, 1), at(0.5, 1),
                           at(1, 1)},
                          0};
        for (const Double3& q : slice.points)
            slice.radius = std::max(slice.radius, length(subtract(q, slice.points[0])));
        const double gap = gap_to_surfaces(geometry, slice, 1, {});
        positive += gap > 0;
        double least = 1;
        for (int i = 0; i <= 8; ++i)
            for (int k = 0; k <= 8; ++k)
                least =
                    std::min(least, distance_to_surfaces(geometry,
                                                         add(origin, add(scaled(u, i / 8.0), scaled(v, k / 8.0))), 1));
        EXPECT_LE(gap, least + 1e-6) << round;
    }
    EXPECT_GT(positive, 1000u);
}

TEST(GapToSurfaces, LeavesOutTheIgnoredFace) {
    const auto plan = plan_of_text(two_surfaces, {});
    const Geometry& geometry = *plan->scene->geometry->kernel_view();
    const Double3 on_square{0.45, 0.45, 0.55};
    BundleSlice slice{};
    slice.points.fill(on_square);
    EXPECT_NEAR(gap_to_surfaces(geometry, slice, 1, {}), 0, 1e-6);
    const double to_ball = length(subtract(on_square, {0.7, 0.2, 0.6})) - 0.1;
    EXPECT_NEAR(gap_to_surfaces(geometry, slice, 1, plan->scene->geometry->face_of(0, 1)), to_ball, 1e-6);
}

}  // namespace
}  // namespace kagero::test

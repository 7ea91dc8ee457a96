// Tests of averages over patches of surfaces: charts, which map points of a surface to texture coordinates u and v and
// their gradients; the mean colours of checkers and textures; and the patch of a ray.
#include "tests/support/linear_image.h"
#include "tests/support/plan_fixture.h"
#include "appearance/footprint.h"
#include "appearance/pyramid.h"
#include "scene/vector3.h"

#include <gtest/gtest.h>

#include <random>

namespace kagero::test {
namespace {

Double3 random_point(std::mt19937& random, double size = 1) {
    std::normal_distribution<double> normal;
    return {size * normal(random), size * normal(random), size * normal(random)};
}

/// Compares the gradients of u and v that a chart returns with central differences of u and v along `tangent`, a vector
/// tangential to the surface.
template <class Chart>
void expect_gradients(const Chart& chart, const Double3& point, const Double3& tangent) {
    const double h = 1e-6;
    const ChartPoint at = chart(point), after = chart(add(point, scaled(tangent, h))),
                     before = chart(add(point, scaled(tangent, -h)));
    EXPECT_NEAR(dot(at.u_gradient, tangent), (after.u - before.u) / (2 * h), 1e-7 * (1 + length(at.u_gradient)));
    EXPECT_NEAR(dot(at.v_gradient, tangent), (after.v - before.v) / (2 * h), 1e-7 * (1 + length(at.v_gradient)));
}

TEST(Chart, GradientsAreThoseOfUAndV) {
    std::mt19937 random(5);
    for (int n = 0; n < 50; ++n) {
        const Double3 point = random_point(random), axis = random_point(random), direction = unit(point);
        const Double3 across = cross(point, random_point(random));
        expect_gradients([](const Double3& p) { return sphere_uv(p); }, point, across);
        expect_gradients([&](const Double3& d) { return sky_uv(d, axis); }, direction, unit(across));
        const Double3 flat = cross(axis, point);
        expect_gradients([&](const Double3& p) { return disk_uv(axis, 0, 100, p); }, flat,
                         cross(axis, random_point(random)));
    }
}

TEST(Chart, HasTheCoordinatesOfTheMeshAtTheCornersOfATriangle) {
    std::mt19937 random(6);
    TriangleMesh mesh;
    for (int i = 0; i < 3; ++i) {
        const Double3 corner = random_point(random), uv = random_point(random);
        mesh.vertices.insert(mesh.vertices.end(), corner.begin(), corner.end());
        mesh.uv.insert(mesh.uv.end(), {uv[0], uv[1]});
        mesh.triangles.push_back(static_cast<std::uint32_t>(i));
    }
    const auto charts = charts_of(mesh);
    ASSERT_EQ(charts.size(), 1u);
    for (const std::size_t i : {0u, 1u, 2u}) {
        const auto [u, v] = triangle_uv(charts[0], vertex(mesh, static_cast<std::uint32_t>(i)));
        EXPECT_NEAR(u, mesh.uv[2 * i], 1e-12);
        EXPECT_NEAR(v, mesh.uv[2 * i + 1], 1e-12);
    }
    EXPECT_TRUE(charts_of(TriangleMesh{}).empty());
}

/// Returns the mean brightness of a checker over 400 × 400 points of the parallelogram with centre (x, y) and the given
/// sides. Lengths are in squares. Bright squares have brightness 1 and dark squares 0.25.
double sampled_mean(double x, double y, const UvPatch& sides) {
    constexpr int n = 400;
    double sum = 0;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const double s = (i + 0.5) / n - 0.5, t = (j + 0.5) / n - 0.5;
            const double square =
                std::floor(x + s * sides.a[0] + t * sides.b[0]) + std::floor(y + s * sides.a[1] + t * sides.b[1]);
            sum += std::fmod(std::abs(square), 2) != 0 ? 0.25 : 1;
        }
    return sum / (n * n);
}

Paint white_checker(double n_u, double n_v) {
    Paint paint{Paint::Kind::checker, {1, 1, 1}, {}, {n_u, n_v}, {}};
    return paint;
}

TEST(Checker, MeansOverAxisParallelRectanglesAreExact) {
    std::mt19937 random(8);
    std::uniform_real_distribution<double> coordinate(-5, 5), size(0, 4);
    for (int n = 0; n < 40; ++n) {
        const double x = coordinate(random), y = coordinate(random), width = size(random), height = size(random);
        const double filtered_mean =
            checker_color(white_checker(4, 2), x / 4, y / 2, {{width / 4, 0}, {0, height / 2}})[0];
        EXPECT_NEAR(filtered_mean, sampled_mean(x, y, {{width, 0}, {0, height}}), 0.01)
            << x << " " << y << " " << width << " " << height;
    }
    EXPECT_NEAR(checker_color(white_checker(1, 1), 0, 0.5, {{0.5, 0}, {0, 0.5}})[0], 0.625, 1e-7);
    EXPECT_NEAR(checker_color(white_checker(1, 1), 0.25, 0.5, {{1, 0}, {0, 0.5}})[0], 0.8125, 1e-7);
    EXPECT_NEAR(checker_color(white_checker(1, 1), 17.3, 0.5, {{2, 0}, {0, 0.5}})[0], 0.625, 1e-7);
}

// With an odd number of squares around a sphere, the last square and the first have the same colour. Beyond the edge of
// a plane there are no squares, and the mean is taken over the part of the patch within the plane.
TEST(Checker, IsAveragedOverExistingSquaresOnly) {
    for (const double u : {-0.001, 0.0, 0.001, 0.999, 1.0}) {
        EXPECT_NEAR(checker_color(white_checker(5, 3), u, 0.1, {{0.01, 0}, {0, 0.01}}, repeat_along_u)[0], 1, 1e-7)
            << u;
        EXPECT_NEAR(checker_color(white_checker(5, 3), 0.1, u, {{0.01, 0}, {0, 0.01}}, clamp_both)[0], 1, 1e-7) << u;
    }
    EXPECT_NEAR(checker_color(white_checker(4, 3), 0, 0.1, {{0.01, 0}, {0, 0.01}}, repeat_along_u)[0], 0.625, 1e-7);
    EXPECT_NEAR(checker_color(white_checker(5, 3), 0.3, 0.1, {{7, 0}, {0, 0.01}}, repeat_along_u)[0],
                0.6 * 1 + 0.4 * 0.25, 1e-7);
    EXPECT_NEAR(checker_color(white_checker(3, 3), 0.5, 0.1, {{7, 0}, {0, 0.01}}, clamp_both)[0], 0.75, 1e-7);
}

// The filter replaces a parallelogram by a rectangle with the same variances. For a general parallelogram this is an
// approximation; its errors here are below 0.16, and below 0.05 in the root mean square.
TEST(Checker, MeansOverGeneralParallelogramsAreApproximate) {
    std::mt19937 random(9);
    std::uniform_real_distribution<double> coordinate(-5, 5);
    double sum2 = 0;
    constexpr int samples = 100;
    for (int n = 0; n < samples; ++n) {
        const double x = coordinate(random), y = coordinate(random);
        const Double3 a = random_point(random), b = random_point(random);
        const UvPatch sides{{a[0], a[1]}, {b[0], b[1]}};
        const double error = checker_color(white_checker(1, 1), x, y, sides)[0] - sampled_mean(x, y, sides);
        EXPECT_NEAR(error, 0, 0.16);
        sum2 += error * error;
    }
    EXPECT_LT(std::sqrt(sum2 / samples), 0.05);
}

TEST(Checker, MeanAlongADiagonalIsTheColorOfTheBrightSquares) {
    for (const double length : {0.3, 2.0, 40.0})
        EXPECT_NEAR(checker_color(white_checker(1, 1), 0, 0, {{length, length}, {0, 0}})[0], 1, 0.02 * length + 0.01)
            << length;
}

// The columns of the image are alternately black and white. A patch along a column has the colour of the column, and
// one across the columns has their mean.
TEST(SurfaceTexture, IsAveragedOverItsPatch) {
    Image stripes{128, 64, std::vector<float>(3 * 128 * 64)};
    for (std::size_t i = 0; i < stripes.rgb.size(); ++i) stripes.rgb[i] = i / 3 % 128 % 2 ? 1.0f : 0.0f;
    const StoredImage image = stored_image(stripes);
    const auto coarser = coarser_images(image, Mapping::plane);
    EXPECT_NEAR(coarser.back().rgb[0], 0.5, 1e-6);
    const auto filtered_mean = [&](const UvPatch& patch) {
        return surface_texture_color(image, coarser, 40.5 / 128, 1.3, patch, repeat_both)[0];
    };
    EXPECT_NEAR(filtered_mean({}), 0, 1e-6);
    EXPECT_NEAR(filtered_mean({{0, 0.2}, {0.5 / 128, 0}}), 0, 1e-6) << "patch along the columns";
    EXPECT_NEAR(filtered_mean({{8.0 / 128, 0}, {0, 0.5 / 64}}), 0.5, 0.02) << "patch across the columns";
    EXPECT_NEAR(filtered_mean({{8.0 / 128, 0}, {0, 8.0 / 64}}), 0.5, 0.02);
}

// The points are a linear function of the film positions. The patch must contain its derivatives. If all positions lie
// on one line, the derivative across the line is 0; a single position has a zero patch.
TEST(FitPatch, FindsTheDerivativesOfALinearMap) {
    std::mt19937 random(7);
    const Double3 right = random_point(random, 1e-3), below = random_point(random, 1e-3), origin = random_point(random);
    const auto mapped = [&](const std::vector<std::array<double, 2>>& positions) {
        std::vector<Double3> points;
        for (const auto& [x, y] : positions) points.push_back(add(origin, add(scaled(right, x), scaled(below, y))));
        return fit_patch(points, positions);
    };
    for (const auto& positions : {std::vector<std::array<double, 2>>{{0.5, 0.5}, {1.5, 0.5}, {0.5, 1.5}, {1.5, 1.5}},
                                  {{8.5, 6.5}, {9.5, 6.5}, {9.5, 7.5}},
                                  {{8.2, 6.3}, {9.1, 6.7}, {8.4, 7.7}, {8.9, 7.1}, {9.9, 6.0}}}) {
        const Patch patch = mapped(positions);
        EXPECT_LT(length(subtract(patch.right, right)), 1e-12);
        EXPECT_LT(length(subtract(patch.below, below)), 1e-12);
    }
    const Patch row = mapped({{0.5, 0.5}, {1.5, 0.5}}), one = mapped({{0.5, 0.5}});
    EXPECT_LT(length(subtract(row.right, right)), 1e-12);
    EXPECT_EQ(length(row.below), 0);
    EXPECT_EQ(length(one.right), 0);
    EXPECT_EQ(length(one.below), 0);
}

}  // namespace
}  // namespace kagero::test

// Averages over pieces of surfaces: coordinates and their gradients, the mean of a checker, the piece that a ray stands
// for, and what they do to pictures.
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

/// Gradients against differences of u and v over a way within the surface.
template <class Chart>
void expect_gradients(const Chart& chart, const Double3& point, const Double3& within) {
    const double h = 1e-6;
    const ChartPoint at = chart(point), after = chart(add(point, scaled(within, h))),
                     before = chart(add(point, scaled(within, -h)));
    EXPECT_NEAR(dot(at.u_gradient, within), (after.u - before.u) / (2 * h), 1e-7 * (1 + length(at.u_gradient)));
    EXPECT_NEAR(dot(at.v_gradient, within), (after.v - before.v) / (2 * h), 1e-7 * (1 + length(at.v_gradient)));
}

TEST(Chart, GradientsAreThoseOfUAndV) {
    std::mt19937 random(5);
    for (int n = 0; n < 50; ++n) {
        const Double3 point = random_point(random), axis = random_point(random), direction = unit(point);
        const Double3 across = cross(point, random_point(random));
        expect_gradients([](const Double3& p) { return on_sphere(p); }, point, across);
        expect_gradients([&](const Double3& d) { return on_sky(d, axis); }, direction, unit(across));
        const Double3 flat = cross(axis, point);
        expect_gradients([&](const Double3& p) { return on_disk(axis, 0, 100, p); }, flat,
                         cross(axis, random_point(random)));
    }
}

TEST(Chart, TrianglesTakeThatOfTheirCorners) {
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
        const auto [u, v] = on_triangle(charts[0], vertex(mesh, static_cast<std::uint32_t>(i)));
        EXPECT_NEAR(u, mesh.uv[2 * i], 1e-12);
        EXPECT_NEAR(v, mesh.uv[2 * i + 1], 1e-12);
    }
    EXPECT_TRUE(charts_of(TriangleMesh{}).empty());
}

/// The mean brightness of a checker over a parallelogram, from very many points.
double ruler_mean(double x, double y, const UvPatch& sides) {
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

TEST(Checker, MeansOverRectanglesAlongTheSquaresAreExact) {
    std::mt19937 random(8);
    std::uniform_real_distribution<double> place(-5, 5), size(0, 4);
    for (int n = 0; n < 40; ++n) {
        const double x = place(random), y = place(random), width = size(random), height = size(random);
        const double seen = checker_color(white_checker(4, 2), x / 4, y / 2, {{width / 4, 0}, {0, height / 2}})[0];
        EXPECT_NEAR(seen, ruler_mean(x, y, {{width, 0}, {0, height}}), 0.01)
            << x << " " << y << " " << width << " " << height;
    }
    EXPECT_NEAR(checker_color(white_checker(1, 1), 0, 0.5, {{0.5, 0}, {0, 0.5}})[0], 0.625, 1e-7);
    EXPECT_NEAR(checker_color(white_checker(1, 1), 0.25, 0.5, {{1, 0}, {0, 0.5}})[0], 0.8125, 1e-7);
    EXPECT_NEAR(checker_color(white_checker(1, 1), 17.3, 0.5, {{2, 0}, {0, 0.5}})[0], 0.625, 1e-7);
}

// Of five squares around a sphere the last and the first have one colour, and beside the edge of a wall there is no
// square.
TEST(Checker, IsAveragedOverSquaresThatAreThere) {
    for (const double u : {-0.001, 0.0, 0.001, 0.999, 1.0}) {
        EXPECT_NEAR(checker_color(white_checker(5, 3), u, 0.1, {{0.01, 0}, {0, 0.01}}, around)[0], 1, 1e-7) << u;
        EXPECT_NEAR(checker_color(white_checker(5, 3), 0.1, u, {{0.01, 0}, {0, 0.01}}, framed)[0], 1, 1e-7) << u;
    }
    EXPECT_NEAR(checker_color(white_checker(4, 3), 0, 0.1, {{0.01, 0}, {0, 0.01}}, around)[0], 0.625, 1e-7);
    EXPECT_NEAR(checker_color(white_checker(5, 3), 0.3, 0.1, {{7, 0}, {0, 0.01}}, around)[0], 0.6 * 1 + 0.4 * 0.25,
                1e-7);
    EXPECT_NEAR(checker_color(white_checker(3, 3), 0.5, 0.1, {{7, 0}, {0, 0.01}}, framed)[0], 0.75, 1e-7);
}

// Askew: the rectangle with the same variances is not the parallelogram.
TEST(Checker, MeansOverAnyParallelogramAreNear) {
    std::mt19937 random(9);
    std::uniform_real_distribution<double> place(-5, 5);
    double sum2 = 0;
    constexpr int samples = 100;
    for (int n = 0; n < samples; ++n) {
        const double x = place(random), y = place(random);
        const Double3 a = random_point(random), b = random_point(random);
        const UvPatch sides{{a[0], a[1]}, {b[0], b[1]}};
        const double off = checker_color(white_checker(1, 1), x, y, sides)[0] - ruler_mean(x, y, sides);
        EXPECT_NEAR(off, 0, 0.16);
        sum2 += off * off;
    }
    EXPECT_LT(std::sqrt(sum2 / samples), 0.05);
}

TEST(Checker, ALineAlongADiagonalSeesOneColour) {
    for (const double length : {0.3, 2.0, 40.0})
        EXPECT_NEAR(checker_color(white_checker(1, 1), 0, 0, {{length, length}, {0, 0}})[0], 1, 0.02 * length + 0.01)
            << length;
}

TEST(SurfaceTexture, IsAveragedOverItsPatch) {
    Image stripes{128, 64, std::vector<float>(3 * 128 * 64)};
    for (std::size_t i = 0; i < stripes.rgb.size(); ++i) stripes.rgb[i] = i / 3 % 128 % 2 ? 1.0f : 0.0f;
    const auto coarser = coarser_images(stripes, Mapping::plane);
    EXPECT_NEAR(coarser.back().rgb[0], 0.5, 1e-6);
    const auto seen = [&](const UvPatch& patch) {
        return surface_texture_color(stripes, coarser, 40.5 / 128, 1.3, patch, tiled)[0];
    };
    EXPECT_NEAR(seen({}), 0, 1e-6);
    EXPECT_NEAR(seen({{0, 0.2}, {0.5 / 128, 0}}), 0, 1e-6) << "along the stripes";
    EXPECT_NEAR(seen({{8.0 / 128, 0}, {0, 0.5 / 64}}), 0.5, 0.02) << "across them";
    EXPECT_NEAR(seen({{8.0 / 128, 0}, {0, 8.0 / 64}}), 0.5, 0.02);
}

TEST(Slope, IsThatOfALinearMap) {
    std::mt19937 random(7);
    const Double3 right = random_point(random, 1e-3), below = random_point(random, 1e-3), origin = random_point(random);
    const auto mapped = [&](const std::vector<std::array<double, 2>>& places) {
        std::vector<Double3> points;
        for (const auto& [x, y] : places) points.push_back(add(origin, add(scaled(right, x), scaled(below, y))));
        return slope_of(points, places);
    };
    for (const auto& places : {std::vector<std::array<double, 2>>{{0.5, 0.5}, {1.5, 0.5}, {0.5, 1.5}, {1.5, 1.5}},
                               {{8.5, 6.5}, {9.5, 6.5}, {9.5, 7.5}},
                               {{8.2, 6.3}, {9.1, 6.7}, {8.4, 7.7}, {8.9, 7.1}, {9.9, 6.0}}}) {
        const Patch patch = mapped(places);
        EXPECT_LT(length(subtract(patch.right, right)), 1e-12);
        EXPECT_LT(length(subtract(patch.below, below)), 1e-12);
    }
    const Patch row = mapped({{0.5, 0.5}, {1.5, 0.5}}), one = mapped({{0.5, 0.5}});
    EXPECT_LT(length(subtract(row.right, right)), 1e-12);
    EXPECT_EQ(length(row.below), 0);
    EXPECT_EQ(length(one.right), 0);
    EXPECT_EQ(length(one.below), 0);
}

constexpr std::uint32_t width = 160, height = 120;

// A floor one below the eye, with squares of size 1, turned by 30 degrees; the horizon lies at mid-height.
const char* const floor_scene = R"(
space.hamiltonian = "flat"
integrator.escape_radius = 5000
camera = { position = [0, 0, 0], look_at = [0, 1, 0], up = [0, 0, 1], fov = 60 }
film.size = [160, 120]
sky.color = [0, 0, 0]
[[object]]
name = "floor"
shape = "rectangle"
origin = [-366.0254, -866.0254, -1]
edge_u = [1732.0508075688772, 1000, 0]
edge_v = [-1000, 1732.0508075688772, 0]
checker = [2000, 2000]
color = [1, 1, 1]
)";

/// What a straight ray through (x, y) of the picture sees of the floor, by a ruler; x and y below the horizon.
double ruler_color(double x, double y) {
    const double pixel = 2 * std::tan(std::numbers::pi / 6) / height, far = 1 / ((y - 0.5 * height) * pixel);
    const double right = (x - 0.5 * width) * pixel * far, c = std::sqrt(0.75), s = 0.5;
    // From the floor's corner, along its edges.
    const double from_x = right + 366.0254, from_y = far + 866.0254;
    const double square = std::floor(c * from_x + s * from_y) + std::floor(-s * from_x + c * from_y);
    return std::fmod(std::abs(square), 2) != 0 ? 0.25 : 1;
}

double rms(const std::vector<double>& differences) {
    double sum = 0;
    for (const double d : differences) sum += d * d;
    return std::sqrt(sum / static_cast<double>(differences.size()));
}

TEST(FilteredFloor, IsTheMeanOverEachPixel) {
    const auto plan = plan_of_text(floor_scene, {});
    Film film(width, height, plan->description().film.layers);
    render(*plan, film);
    std::vector<double> filtered, sampled;
    for (std::uint32_t y = height / 2 + 2; y < height;
         ++y)  // a pixel at the horizon sees the sky, or where the floor ends
        for (std::uint32_t x = 0; x < width; ++x) {
            double mean = 0;
            constexpr int n = 16;
            for (int i = 0; i < n * n; ++i) mean += ruler_color(x + (i % n + 0.5) / n, y + (i / n + 0.5) / n) / (n * n);
            filtered.push_back(*film.pixel("color", x, y) - mean);
            sampled.push_back(ruler_color(x + 0.5, y + 0.5) - mean);
        }
    EXPECT_LT(rms(filtered), 0.2 * rms(sampled)) << rms(filtered) << " " << rms(sampled);
}

TEST(FilteredFloor, IsFlatTowardsTheHorizon) {
    const auto plan = plan_of_text(floor_scene, {"object.floor.checker=[8000,8000]"});
    Film film(width, height, plan->description().film.layers);
    render(*plan, film);
    std::vector<double> off;
    for (std::uint32_t y = height / 2 + 1; y < height / 2 + 4; ++y)  // here a pixel covers hundreds of squares
        for (std::uint32_t x = 0; x < width; ++x) {
            off.push_back(*film.pixel("color", x, y) - 0.625);
            EXPECT_LT(std::abs(off.back()), 0.1) << x << "," << y;
        }
    EXPECT_LT(rms(off), 0.01);  // of single rays: 0.375
}

// Two parts of a mesh, one far behind the other, each within one bright square: between them no pixel sees the dark
// one.
TEST(FilteredMesh, IsNotAveragedAcrossItsSilhouette) {
    const auto path = std::filesystem::temp_directory_path() / ("kagero-parts-" + std::to_string(::getpid()) + ".obj");
    std::ofstream(path)
        << "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv -60 -60 -100\nv 60 -60 -100\nv 60 60 -100\nv -60 60 -100\n"
           "vt 0.05 0.1\nvt 0.15 0.1\nvt 0.15 0.2\nvt 0.05 0.2\nvt 0.55 0.1\nvt 0.65 0.1\nvt 0.65 0.2\nvt 0.55 0.2\n"
           "f 1/1 2/2 3/3 4/4\nf 5/5 6/6 7/7 8/8\n";
    for (const char* spp : {"film.spp=1", "film.spp=4"}) {
        const auto plan = plan_of_text(
            "space.hamiltonian = \"flat\"\nintegrator.escape_radius = 500\n"
            "camera = { position = [0.013, 0.021, 3], look_at = [0.013, 0.021, 0], up = [0, 1, 0], fov = 40 "
            "}\nfilm.size = [60, 40]\n"
            "[[object]]\nshape = \"mesh\"\nfile = \"" +
                path.string() + "\"\nchecker = [4, 1]\ncolor = [1, 1, 1]\n",
            {spp});
        Film film(60, 40, plan->description().film.layers);
        render(*plan, film);
        for (std::uint32_t y = 0; y < 40; ++y)
            for (std::uint32_t x = 0; x < 60; ++x)
                ASSERT_NEAR(*film.pixel("color", x, y), 1, 1e-6) << spp << " " << x << "," << y;
    }
    std::filesystem::remove(path);
}

/// The room with its hole, as single rays see it without their neighbours.
double single_ray_color(const Plan& plan, const RayEnd& end, std::size_t channel) {
    if (end.status != Status::hit) return 0;
    return plan.scene->paints->surface_color(end.surface, end.primitive, {end.q[0], end.q[1], end.q[2]},
                                             {end.v[0], end.v[1], end.v[2]})[channel];
}

TEST(FilteredRoom, IsNearerToTheMeanOfManyRaysThanSingleRaysAre) {
    const auto one = plan_of_file(KAGERO_SCENES "/room.toml", {"film.size=[96,96]"});
    const auto many = plan_of_file(KAGERO_SCENES "/room.toml", {"film.size=[96,96]", "film.spp=36"});
    Film film(96, 96, {"color"}), mean(96, 96, {"color"});
    render(*one, film), render(*many, mean);
    std::vector<RayStart> starts;
    for (std::uint32_t i = 0; i < 96 * 96; ++i) starts.push_back(pixel_ray(*one, i % 96, i / 96));
    std::vector<RayEnd> ends;
    trace(*one, starts, ends);
    std::vector<double> filtered, sampled;
    for (std::size_t i = 0; i < 96 * 96; ++i)
        for (std::size_t k = 0; k < 3; ++k) {
            filtered.push_back(film.plane("color")[3 * i + k] - mean.plane("color")[3 * i + k]);
            sampled.push_back(single_ray_color(*one, ends[i], k) - mean.plane("color")[3 * i + k]);
        }
    EXPECT_LT(rms(filtered), 0.5 * rms(sampled)) << rms(filtered) << " " << rms(sampled);
}

/// The picture of a scene of 61 × 53 pixels whole, in tiles, and a part of it, in scanlines.
void expect_same_part(const std::function<std::unique_ptr<Plan>(const Overrides&, const Options&)>& plan_with) {
    for (const char* spp : {"film.spp=1", "film.spp=3"}) {
        const Overrides overrides{"film.size=[61,53]", spp};
        Options options;
        options.threads = 1, options.strategy = Strategy::packet;
        const auto whole_plan = plan_with(overrides, options);
        options.threads = 3, options.schedule = Schedule::scanline, options.crop = {3, 5, 36, 53};
        const auto part_plan = plan_with(overrides, options);
        Film whole(61, 53, {"color"}), part(33, 48, {"color"});
        render(*whole_plan, whole), render(*part_plan, part);
        for (std::uint32_t y = 5; y < 53; ++y)
            for (std::uint32_t x = 3; x < 36; ++x)
                ASSERT_EQ(*whole.pixel("color", x, y), *part.pixel("color", x - 3, y - 5)) << x << "," << y;
    }
}

TEST(FilteredRoom, DependsOnNeitherTilesNorCrops) {
    expect_same_part([](const Overrides& overrides, const Options& options) {
        return plan_of_file(KAGERO_SCENES "/room.toml", overrides, options);
    });
}

// So rough that of three rays the first and the last may meet what the middle one does, and not what each other does.
TEST(FilteredMesh, DependsOnNeitherTilesNorCrops) {
    const auto path = std::filesystem::temp_directory_path() / ("kagero-rough-" + std::to_string(::getpid()) + ".obj");
    {
        constexpr int n = 64;
        std::mt19937 random(1);
        std::uniform_real_distribution<double> rise(0, 1.15 / n);
        std::ofstream file(path);
        for (int i = 0; i < (n + 1) * (n + 1); ++i)
            file << "v " << double(i % (n + 1)) / n - 0.5 << ' ' << double(i / (n + 1)) / n - 0.5 << ' ' << rise(random)
                 << '\n';
        for (int i = 0; i < (n + 1) * (n + 1); ++i)
            file << "vt " << double(i % (n + 1)) / n << ' ' << double(i / (n + 1)) / n << '\n';
        for (int i = 0; i < n * n; ++i) {
            const int a = i / n * (n + 1) + i % n + 1, b = a + 1, c = a + n + 1, d = c + 1;
            for (const auto& [p, q, r] : {std::array{a, b, d}, std::array{a, d, c}})
                file << "f " << p << '/' << p << ' ' << q << '/' << q << ' ' << r << '/' << r << '\n';
        }
    }
    expect_same_part([&](const Overrides& overrides, const Options& options) {
        return plan_of_text(
            "space.hamiltonian = \"flat\"\ncamera = { position = [0, 0, 2], look_at = [0, 0, 0], up = [0, 1, 0], fov = "
            "30 }\n"
            "[[object]]\nshape = \"mesh\"\nfile = \"" +
                path.string() + "\"\nchecker = [30, 30]\ncolor = [1, 1, 1]\n",
            overrides, options);
    });
    std::filesystem::remove(path);
}

}  // namespace
}  // namespace kagero::test

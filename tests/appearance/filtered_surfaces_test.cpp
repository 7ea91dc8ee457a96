// Tests of pictures whose surfaces have checkers: each pixel shows the mean over the patch that it covers.
#include "tests/support/plan_fixture.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

namespace kagero::test {
namespace {

constexpr std::uint32_t width = 160, height = 120;

// A floor at a distance of 1 below the camera, with squares of size 1. The floor is rotated by 30 degrees around the
// vertical. The horizon is at half the height of the picture.
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

/// Returns the exact brightness of the floor at the film position (x, y), which is below the horizon.
double exact_brightness(double x, double y) {
    const double pixel = 2 * std::tan(std::numbers::pi / 6) / height, forward = 1 / ((y - 0.5 * height) * pixel);
    const double right = (x - 0.5 * width) * pixel * forward, c = std::sqrt(0.75), s = 0.5;
    // Position relative to the corner `origin` of the floor.
    const double from_x = right + 366.0254, from_y = forward + 866.0254;
    const double square_index_sum = std::floor(c * from_x + s * from_y) + std::floor(-s * from_x + c * from_y);
    return std::fmod(std::abs(square_index_sum), 2) != 0 ? 0.25 : 1;
}

double rms(const std::vector<double>& differences) {
    double sum = 0;
    for (const double d : differences) sum += d * d;
    return std::sqrt(sum / static_cast<double>(differences.size()));
}

// Pixels are compared with the mean of 16 × 16 exact samples per pixel. The root mean square error must be less than a
// fifth of the error of one sample at the centre of each pixel.
TEST(FilteredFloor, IsTheMeanOverEachPixel) {
    const auto plan = plan_of_text(floor_scene, {});
    Film film(width, height, plan->description().film.layers);
    render(*plan, film);
    std::vector<double> filtered, sampled;
    // Pixels at the horizon, which show the sky or the edge of the floor, are left out.
    for (std::uint32_t y = height / 2 + 2; y < height; ++y)
        for (std::uint32_t x = 0; x < width; ++x) {
            double mean = 0;
            constexpr int n = 16;
            for (int i = 0; i < n * n; ++i)
                mean += exact_brightness(x + (i % n + 0.5) / n, y + (i / n + 0.5) / n) / (n * n);
            filtered.push_back(*film.pixel("color", x, y) - mean);
            sampled.push_back(exact_brightness(x + 0.5, y + 0.5) - mean);
        }
    EXPECT_LT(rms(filtered), 0.2 * rms(sampled)) << rms(filtered) << " " << rms(sampled);
}

// Near the horizon a pixel covers hundreds of squares. Its brightness must be their mean, (1 + 0.25)/2. The
// brightness of single rays has a standard deviation of 0.375.
TEST(FilteredFloor, IsUniformNearTheHorizon) {
    const auto plan = plan_of_text(floor_scene, {"object.floor.checker=[8000,8000]"});
    Film film(width, height, plan->description().film.layers);
    render(*plan, film);
    std::vector<double> errors;
    for (std::uint32_t y = height / 2 + 1; y < height / 2 + 4; ++y)
        for (std::uint32_t x = 0; x < width; ++x) {
            errors.push_back(*film.pixel("color", x, y) - 0.625);
            EXPECT_LT(std::abs(errors.back()), 0.1) << x << "," << y;
        }
    EXPECT_LT(rms(errors), 0.01);
}

// The mesh consists of two separate parts, one far behind the other. Each part lies within one bright square of the
// checker. At the silhouette, the filter must not interpolate u and v between the parts, because dark squares lie
// between them.
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

/// Returns the colour of a ray of the room scene at its end point, without averaging over a patch.
double unfiltered_color(const Plan& plan, const RayEnd& end, std::size_t channel) {
    if (end.status != Status::hit) return 0;
    return plan.scene->paints->surface_color(end.surface, end.primitive, {end.q[0], end.q[1], end.q[2]},
                                             {end.v[0], end.v[1], end.v[2]})[channel];
}

// The filtered picture with one ray per pixel and the unfiltered colours of the same rays are compared with the picture
// of 36 rays per pixel.
TEST(FilteredRoom, IsCloserToTheMeanOfManyRaysThanUnfilteredColors) {
    const auto one = plan_of_file(KAGERO_SCENES "/room.toml", {"film.size=[96,96]"});
    const auto many = plan_of_file(KAGERO_SCENES "/room.toml", {"film.size=[96,96]", "film.spp=36"});
    Film film(96, 96, {"color"}), mean(96, 96, {"color"});
    render(*one, film);
    render(*many, mean);
    std::vector<RayStart> starts;
    for (std::uint32_t i = 0; i < 96 * 96; ++i) starts.push_back(pixel_ray_start(*one, i % 96, i / 96));
    std::vector<RayEnd> ends;
    trace(*one, starts, ends);
    std::vector<double> filtered, sampled;
    for (std::size_t i = 0; i < 96 * 96; ++i)
        for (std::size_t k = 0; k < 3; ++k) {
            filtered.push_back(film.plane("color")[3 * i + k] - mean.plane("color")[3 * i + k]);
            sampled.push_back(unfiltered_color(*one, ends[i], k) - mean.plane("color")[3 * i + k]);
        }
    EXPECT_LT(rms(filtered), 0.5 * rms(sampled)) << rms(filtered) << " " << rms(sampled);
}

/// Renders the whole picture of 61 × 53 pixels on one thread, and a crop of it on three threads with the schedule
/// `scanline`. Expects that the colours of the crop are bitwise equal to those of the whole picture.
void expect_crop_equals_part_of_picture(
    const std::function<std::unique_ptr<Plan>(const Overrides&, const Options&)>& plan_with) {
    for (const char* spp : {"film.spp=1", "film.spp=3"}) {
        const Overrides overrides{"film.size=[61,53]", spp};
        Options options;
        options.threads = 1;
        options.strategy = Strategy::packet;
        const auto whole_plan = plan_with(overrides, options);
        options.threads = 3;
        options.schedule = Schedule::scanline;
        options.crop = {3, 5, 36, 53};
        const auto part_plan = plan_with(overrides, options);
        Film whole(61, 53, {"color"}), part(33, 48, {"color"});
        render(*whole_plan, whole);
        render(*part_plan, part);
        for (std::uint32_t y = 5; y < 53; ++y)
            for (std::uint32_t x = 3; x < 36; ++x)
                ASSERT_EQ(*whole.pixel("color", x, y), *part.pixel("color", x - 3, y - 5)) << x << "," << y;
    }
}

TEST(FilteredRoom, DoesNotDependOnTilesOrCrops) {
    expect_crop_equals_part_of_picture([](const Overrides& overrides, const Options& options) {
        return plan_of_file(KAGERO_SCENES "/room.toml", overrides, options);
    });
}

// The mesh is so rough that the relation SceneGeometry::on_same_face between ray ends is not transitive. The second of
// three ray ends can be on the same face as the first and as the third, although these two are on different faces. The
// patches must nevertheless not depend on tiles.
TEST(FilteredMesh, DoesNotDependOnTilesOrCrops) {
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
    expect_crop_equals_part_of_picture([&](const Overrides& overrides, const Options& options) {
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

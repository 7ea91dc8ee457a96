// Tests of cameras: directions, starts and frequencies of rays are compared with closed forms.
#include "rays/camera.h"
#include "tests/support/plan_fixture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace kagero::test {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

const char* const ball = R"([space]
hamiltonian = "flat"
[camera]
position = [4, 0, 0]
look_at = [0, 0, 0]
up = [0, 0, 1]
[film]
size = [48, 36]
layers = ["color", "status", "depth", "steps", "object"]
[[object]]
name = "ball"
shape = "sphere"
center = [0, 0, 0]
radius = 0.75
color = [1, 1, 1]
)";

const char* const hole = R"([space]
hamiltonian = "schwarzschild"
rg = 0.5
center = [0.25, 0, 0]
[camera]
position = [5, 1, 0.5]
look_at = [0, 0, 0]
up = [0, 0, 1]
[film]
size = [24, 18]
layers = ["color", "status", "depth", "steps", "gradients", "object"]
[sky]
checker = true
[[object]]
shape = "sphere"
center = [-1, 0, 2]
radius = 0.75
)";

Film picture(const Plan& plan) {
    Film film = film_of(plan);
    render(plan, film);
    return film;
}

double distance(const double (&p)[3], const Double3& d) {
    return std::hypot(p[0] - d[0], p[1] - d[1], p[2] - d[2]);
}

// In flat space |p| = 1, and p is the direction of the ray. Longitude increases to the right of the picture, which is
// the right side of the observer.
TEST(Equirectangular, HasRaysInTheDirectionsOfLongitudeAndLatitude) {
    const auto plan = plan_of_text(ball, {"camera.type=equirectangular", "camera.position=[0,4,0]"});
    const double width = 48, height = 36;
    for (std::uint32_t y = 0; y < 36; ++y)
        for (std::uint32_t x = 0; x < 48; ++x) {
            const double east = ((x + 0.5) / width - 0.5) * 2 * std::numbers::pi;
            const double north = (0.5 - (y + 0.5) / height) * std::numbers::pi;
            // The camera looks along −y and z is up, so that −x is on the right.
            const Double3 d{-std::sin(east) * std::cos(north), -std::cos(east) * std::cos(north), std::sin(north)};
            EXPECT_LE(distance(pixel_ray_start(*plan, x, y).p, d), 8 * epsilon) << x << "," << y;
        }
}

TEST(Equirectangular, MakesUpOrthogonalToTheViewingDirection) {
    const auto plan =
        plan_of_text(ball, {"camera.type=equirectangular", "camera.up=[-0.7,0,1]", "camera.look_at=[0,0,-3]"});
    EXPECT_LE(distance(camera_ray(*plan, 24, 18).start.p, {-0.8, 0, -0.6}), 8 * epsilon);  // the middle
    EXPECT_LE(distance(camera_ray(*plan, 24, 0).start.p, {-0.6, 0, 0.8}), 8 * epsilon);    // the zenith
    EXPECT_LE(distance(camera_ray(*plan, 36, 18).start.p, {0, 1, 0}), 8 * epsilon);  // a quarter turn to the right
}

// Camera and sky use the same longitude and latitude. A picture of the sky must be equal to the image of the sky, texel
// by texel.
TEST(Equirectangular, RendersTheImageOfTheSky) {
    const auto path = std::filesystem::temp_directory_path() / ("kagero-sky-" + std::to_string(::getpid()) + ".exr");
    Film sky(32, 16, {"color"});
    std::mt19937 random(1);
    for (std::uint32_t i = 0; i < 32 * 16 * 3; ++i)
        sky.plane("color")[i] = float(random() % 256) / 256;  // exact as a half float
    write_film(sky, path.string(), {});
    const auto plan = plan_of_text(
        "space.hamiltonian = \"flat\"\ncamera = { type = \"equirectangular\", position = [1, 2, 3], look_at = "
        "[2, 2, 3], up = [0, 0, 1] }\nfilm.size = [32, 16]\nsky.texture = \"" +
            path.string() + "\"\n",
        {});
    std::filesystem::remove(path);
    const Film film = picture(*plan);
    // A texel coordinate is at most 32. Its error is a few roundings divided by the sine of 5.6°, the polar distance of
    // the first row.
    for (std::uint32_t i = 0; i < 32 * 16 * 3; ++i)
        EXPECT_NEAR(film.plane("color")[i], sky.plane("color")[i], 2e-7) << i;
}

TEST(Orthographic, HasParallelRaysAtADistanceOfOnePixel) {
    const auto plan = plan_of_text(ball, {"camera.type=orthographic", "camera.height=1.8"});
    for (std::uint32_t y = 0; y < 36; ++y)
        for (std::uint32_t x = 0; x < 48; ++x) {
            const RayStart ray = pixel_ray_start(*plan, x, y);
            EXPECT_LE(distance(ray.p, {-1, 0, 0}), 8 * epsilon);
            EXPECT_LE(distance(ray.q, {4, (x + 0.5 - 24) * 0.05, (17.5 - y) * 0.05}), 16 * epsilon) << x << "," << y;
        }
}

// The ball appears as a circle. Its depth is compared with the depth of a sphere. The tolerance is four roundings of
// float.
TEST(Orthographic, RendersABallAsACircle) {
    const auto plan = plan_of_text(ball, {"camera.type=orthographic"});
    Film film = picture(*plan);
    for (std::uint32_t y = 0; y < 36; ++y)
        for (std::uint32_t x = 0; x < 48; ++x) {
            const double pixel = 2.0 / 36, radius = std::hypot((x + 0.5 - 24) * pixel, (y + 0.5 - 18) * pixel);
            const bool inside = radius < 0.75;
            ASSERT_EQ(*film.pixel("status", x, y), inside ? 0 : 1) << x << "," << y;
            const double depth = inside ? 4 - std::sqrt(0.75 * 0.75 - radius * radius) : 0;
            EXPECT_NEAR(*film.pixel("depth", x, y), depth, 4 * 1.2e-7);
        }
}

// The area of the ball's picture is compared with that of a circle. The edge of the circle crosses about 130 pixels.
// With 64 samples of a (0,2)-sequence, the covered share of each of these pixels has an error of about 1/64.
TEST(SamplesOfAPixel, AverageToItsCoveredShare) {
    const auto plan = plan_of_text(ball, {"camera.type=orthographic", "film.spp=64"});
    Film film = picture(*plan);
    double area = 0;
    const double pixel = 2.0 / 36;
    for (std::uint32_t y = 0; y < 36; ++y)
        for (std::uint32_t x = 0; x < 48; ++x) area += *film.pixel("color", x, y) * pixel * pixel;
    EXPECT_NEAR(area, std::numbers::pi * 0.75 * 0.75, std::sqrt(130.0) / 64 * pixel * pixel);
    EXPECT_EQ(*film.pixel("color", 24, 18), 1.0f);
    EXPECT_EQ(*film.pixel("steps", 24, 18), 1.0f);
}

// Near the hole, the rest frame of the static observer depends on the position. Each camera ray is compared with the
// ray that a static observer at its start sees in the viewing direction.
TEST(Orthographic, HasAnObserverAtTheStartOfEachRay) {
    const auto plan = plan_of_text(hole, {"camera.type=orthographic", "camera.height=4"});
    for (std::uint32_t y = 0; y < 18; y += 5)
        for (std::uint32_t x = 0; x < 24; x += 5) {
            const RayStart ray = pixel_ray_start(*plan, x, y);
            const RayInput given{{ray.q[0] + 0.25, ray.q[1], ray.q[2]}, plan->view.forward};
            const RayStart expected = start_rays(*plan, {given}, ObserverKind::static_)[0];
            EXPECT_LE(distance(ray.p, {expected.p[0], expected.p[1], expected.p[2]}), 64 * epsilon);
            EXPECT_NEAR(ray.pt, 1, 2 * epsilon);
        }
}

// A static observer at r measures 1/√(1 − r_g/r) times the frequency at infinity.
TEST(CameraRay, HasTheBlueshiftOfAStaticObserver) {
    for (const char* type : {"perspective", "equirectangular", "orthographic"}) {
        const auto plan = plan_of_text(hole, {std::string("camera.type=") + type});
        const CameraRay ray = camera_ray(*plan, 3, 5);
        const double r = std::hypot(ray.start.q[0], ray.start.q[1], ray.start.q[2]);
        EXPECT_NEAR(ray.frequency, 1 / std::sqrt(1 - 0.5 / r), 64 * epsilon) << type;
    }
}

// The camera rays that the kernel generates must have, bit for bit, the same ends as the camera rays that the program
// generates.
TEST(CameraRay, IsTheRayThatTheKernelGenerates) {
    const auto plan = plan_of_text(hole, {});
    ASSERT_NE(plan->job().camera, nullptr);
    const Tile tile{0, 0, 24, 18};
    std::vector<RayEnd> generated(24 * 18), listed;
    Counters counters{};
    const Job job = plan->job();
    plan->run.kernel->trace(&job, &tile, generated.data(), &counters);
    std::vector<RayStart> starts;
    for (std::uint32_t y = 0; y < 18; ++y)
        for (std::uint32_t x = 0; x < 24; ++x) starts.push_back(pixel_ray_start(*plan, x, y));
    trace(*plan, starts, listed);
    for (std::size_t i = 0; i < generated.size(); ++i) {
        ASSERT_EQ(generated[i].status, listed[i].status) << i;
        for (int k = 0; k < 3; ++k) ASSERT_EQ(generated[i].p[k], listed[i].p[k]) << i;
    }
}

void expect_same(const Film& a, const Film& b, const std::string& what) {
    for (const LayerInfo* layer : a.layers()) {
        const std::size_t floats = std::size_t{a.width()} * a.height() * layer->channels.size();
        for (std::size_t i = 0; i < floats; ++i)
            ASSERT_EQ(a.plane(layer->name)[i], b.plane(layer->name)[i]) << what << " " << layer->name << " " << i;
    }
}

TEST(Pictures, DependOnNeitherThreadsCropNorStrategy) {
    for (const char* type : {"perspective", "equirectangular", "orthographic"})
        for (const char* spp : {"1", "5"}) {
            const Overrides overrides{std::string("camera.type=") + type, std::string("film.spp=") + spp,
                                      "film.size=[40,37]"};
            Options options = with_strategy("packet");
            const Film whole = picture(*plan_of_text(hole, overrides, options));
            options.threads = 3;
            expect_same(picture(*plan_of_text(hole, overrides, options)), whole, "threads");
            expect_same(picture(*plan_of_text(hole, overrides, with_strategy("scalar"))), whole, "scalar");
            options.crop = {3, 5, 35, 34};
            Film part = picture(*plan_of_text(hole, overrides, options));
            for (std::uint32_t y = 5; y < 34; ++y)
                for (std::uint32_t x = 3; x < 35; ++x)
                    ASSERT_EQ(*part.pixel("color", x - 3, y - 5), *const_cast<Film&>(whole).pixel("color", x, y))
                        << x << "," << y;
        }
}

TEST(Pictures, DependOnTheSeedOnlyWithSeveralSamplesPerPixel) {
    const auto rendered = [](const char* spp, const char* seed) {
        return picture(*plan_of_text(hole, {std::string("film.spp=") + spp, std::string("film.seed=") + seed}));
    };
    expect_same(rendered("1", "0"), rendered("1", "1"), "seed");
    const Film a = rendered("4", "0"), b = rendered("4", "1");
    int different = 0;
    for (std::size_t i = 0; i < std::size_t{24} * 18 * 3; ++i) different += a.plane("color")[i] != b.plane("color")[i];
    EXPECT_GT(different, 10);
}

}  // namespace
}  // namespace kagero::test

// Tests of the velocities of cameras and of the distant observers of the sky. The expected values are closed forms, or
// those of other observers.
#include "tests/support/velocity_scenes.h"

#include "scene/value.h"
#include "scene/vector3.h"
#include "spaces/rest_frame.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kagero::test {
namespace {

const std::string bubble = R"toml([space]
hamiltonian = "formula"
H = "0.5*(px^2 + py^2 + pz^2 - (pt - v*(1 - F)*px)^2)"
sky_frame = ["-v", 0, "0*x"]
[space.constants]
pt = 1
v = 0.5
[space.let]
rs = "sqrt(x^2 + y^2 + z^2 + 1e-20)"
F = "(tanh(4*(rs + 2)) - tanh(4*(rs - 2)))/(2*tanh(8))"
[integrator]
escape_radius = 20
[camera]
position = [0, 0, 0]
look_at = [1, 0, 0]
up = [0, 0.6, 0.8]
fov = 90
[film]
size = [2, 2]
)toml";

// A star at the angle χ from the direction of motion is seen at this angle from inside the bubble, and its frequency is
// 1 + v cos χ times as high (Alcubierre 1994).
TEST(SkyFrame, ShowsTheStarsOfAWarpBubbleWhereTheyAre) {
    for (const auto& [look_at, expected] : {std::pair{Double3{1, 0, 0}, 1.5}, {Double3{-1, 0, 0}, 0.5},
                                            {Double3{0, 1, 0}, 1.0}, {Double3{0, -0.6, 0.8}, 1.0}}) {
        const auto plan = plan_of_text(bubble, {"camera.look_at=" + to_toml(look_at)});
        const CentralRay ray = central_ray(*plan);
        EXPECT_EQ(ray.end.status, Status::escaped);
        EXPECT_NEAR(ray.redshift, expected, 1e-8);
        EXPECT_LE(length(subtract(ray.sky.direction, look_at)), 1e-7) << to_toml(look_at);
    }
    const auto without = plan_of_text(bubble, {"space.sky_frame=[0,0,0]", "camera.look_at=[0,1,0]"});
    EXPECT_NEAR(central_ray(*without).redshift, std::sqrt(0.75), 1e-8);
}

// The frequency for an observer at rest at the distance r is 1/√(1 − r_g/r) times that at infinity.
TEST(SkyFrame, RefersToTheEndOfTheRay) {
    const std::string built_in = "[space]\nhamiltonian = \"schwarzschild\"\nrg = 1\n";
    for (const std::string& space : {schwarzschild, built_in})
        for (const std::string unit : {"1", "1e9"}) {
            if (space != built_in && unit != "1") continue;
            const Overrides view = unit == "1" ? Overrides{"camera.look_at=[60,9,9]"}
                                               : Overrides{"camera.position=[0,-29.5e9,5.2e9]", "space.rg=1e9",
                                                           "camera.look_at=[60e9,9e9,9e9]",
                                                           "integrator.escape_radius=60e9"};
            Overrides framed = view;
            framed.emplace_back("space.sky_frame=[0,0,0]");
            const double plain = central_ray(*plan_of_text(space + camera, view)).redshift,
                         actual = central_ray(*plan_of_text(space + camera, framed)).redshift;
            EXPECT_NEAR(actual / plain, std::sqrt(1 - 1 / 60.0), 1e-9);
            framed.back() = "space.sky_frame=[\"0.001*x/" + unit + "\",0,0]";
            EXPECT_LT(central_ray(*plan_of_text(space + camera, framed)).redshift, 0.99 * actual);
        }
}

// With a negative factor, the metric has the signature +−−−.
TEST(Redshift, DoesNotDependOnAConstantFactorOfH) {
    const Overrides view{"camera.position=[0,-8,6]", "camera.look_at=[60,-8,9]"};
    for (const std::string factor : {"1", "0.5", "2", "1e6", "-0.5", "-3"}) {
        std::string text = schwarzschild + camera + disk;
        text.replace(text.find("0.5*(px"), 4, factor + '*');
        EXPECT_NEAR(central_ray(*plan_of_text(text, view)).redshift, 1 / std::sqrt(0.9), 1e-6) << factor;
        for (const Overrides& overrides : {Overrides{"camera.look_at=[5,0,0]"},
                                           {"camera.look_at=[60,0,0]", "camera.velocity=[0.1,0.2,0.3]"},
                                           {"camera.look_at=[60,9,0]", "space.sky_frame=[0.1,0.2,0.3]"}}) {
            const CentralRay actual = central_ray(*plan_of_text(text, overrides)),
                             expected = central_ray(*plan_of_text(schwarzschild + camera + disk, overrides));
            EXPECT_NEAR(actual.redshift, expected.redshift, 1e-6) << factor << ' ' << overrides.back();
            EXPECT_EQ(actual.end.status, expected.end.status);
            if (actual.end.status == Status::escaped) {
                EXPECT_LE(length(subtract(actual.sky.direction, expected.sky.direction)), 1e-6) << factor;
            }
        }
    }
}

// For a camera with speed v in isotropic coordinates, the frequency is that of special relativity, times the blueshift
// of an observer at rest. The local speed is v u³/w, with u = 1 + M/2r and w = 1 − M/2r.
TEST(CameraVelocity, ShiftsFrequenciesAndDirections) {
    const std::string text = R"toml([space]
hamiltonian = "formula"
H = "0.5*((px^2 + py^2 + pz^2)/u^4 - pt^2*(u/w)^2)"
capture = "w"
[space.constants]
pt = 1
[space.let]
R = "sqrt(x^2 + y^2 + z^2)"
u = "1 + 0.5/R"
w = "1 - 0.5/R"
[integrator]
escape_radius = 100
[camera]
position = [-14, 0, 0]
look_at = [-14, 1, 0]
up = [0, 0, 1]
velocity = [0, 0.25, 0]
[film]
size = [2, 2]
)toml";
    const double u = 1 + 0.5 / 14, w = 1 - 0.5 / 14, speed = 0.25 * u * u * u / w;
    for (const auto& [look_at, cosine] : {std::pair{"[-14, 1, 0]", 1.0}, {"[-14, -1, 0]", -1.0}, {"[-15, 0, 0]", 0.0},
                                          {"[-14.6, 0.8, 0]", 0.8}}) {
        const CentralRay ray = central_ray(*plan_of_text(text, {std::string("camera.look_at=") + look_at}));
        EXPECT_EQ(ray.end.status, Status::escaped);
        EXPECT_NEAR(ray.redshift, u / w * std::sqrt(1 - speed * speed) / (1 - speed * cosine), 1e-9) << look_at;
    }
    const Overrides bright{"space.constants.pt=1000"};
    EXPECT_NEAR(central_ray(*plan_of_text(text, bright)).redshift, central_ray(*plan_of_text(text, {})).redshift,
                1e-12);
    const Overrides formula{"camera.velocity=[0,\"-0.25*x/14\",0]"};
    EXPECT_NEAR(central_ray(*plan_of_text(text, formula)).redshift,
                u / w * std::sqrt((1 + speed) / (1 - speed)), 1e-9);
}

TEST(CameraVelocity, OfACameraAtRestGivesTheViewOfTheStaticObserver) {
    std::vector<std::pair<std::string, std::string>> cases{{schwarzschild, "[0, -10, 3]"}};
    if (is_available("kerr")) {
        const std::string hole = "[space]\nhamiltonian = \"kerr\"\nmass = 0.5\nspin = 0.8\n";
        for (const char* position : {"[0, -10, 3]", "[0.1, 0.2, 0.85]"}) cases.emplace_back(hole, position);
    }
    for (const auto& [space, position] : cases) {
        const Override at = std::string("camera.position=") + position;
        const auto moving = plan_of_text(space + camera, {at, "camera.velocity=[0,0,0]"}),
                   at_rest = plan_of_text(space + camera, {at});
        for (std::uint32_t i = 0; i < 48; ++i) {
            const CameraRay a = camera_ray(*moving, i + 0.5, 7.5), b = camera_ray(*at_rest, i + 0.5, 7.5);
            EXPECT_EQ(a.frequency, 1);
            EXPECT_EQ(a.start.ingoing, b.start.ingoing);
            const double scale = b.start.pt / a.start.pt, size = std::hypot(b.start.p[0], b.start.p[1], b.start.p[2]);
            EXPECT_NEAR(b.frequency, scale, 1e-12 * size);
            for (int k = 0; k < 3; ++k) {
                EXPECT_NEAR(a.start.q[k], b.start.q[k], 1e-14);
                EXPECT_NEAR(scale * a.start.p[k], b.start.p[k], 1e-11 * size) << position;
            }
        }
    }
}

// On the axis of a hole, matter that falls from rest at infinity has u^r = −√f with f = 2Mr/(r² + a²), and
// dt/dτ = (1 − f √f)/(1 − f) in ingoing coordinates. Inside the horizon, these are the coordinates of the scene.
// Outside, the time of the scene is t' with dt' = dt − 2f/(1 − f) dr.
TEST(CameraVelocity, OfFallingMatterGivesTheFallingObserver) {
    std::vector<std::pair<std::string, double>> cases{{"hamiltonian = \"schwarzschild\"\nrg = 1\n", 0}};
    if (is_available("kerr")) cases.emplace_back("hamiltonian = \"kerr\"\nmass = 0.5\nspin = 0.8\n", 0.4);
    for (const auto& [keys, spin] : cases) {
        const auto plan = plan_of_text("[space]\n" + keys + camera, {});
        const Space& space = plan->scene->space;
        const double horizon = 0.5 + std::sqrt(0.25 - spin * spin);
        for (const double r : {0.4, 0.7, 1.3, 5.0}) {
            const bool inside = r < horizon;
            const double f = r / (r * r + spin * spin), rate = (1 - f * std::sqrt(f)) / (1 - f),
                         scene_rate = inside ? rate : rate + 2 * f / (1 - f) * std::sqrt(f);
            const double q[3] = {0, 0, -r};
            StartMap moving, falling;
            ASSERT_EQ(make_moving_map(space, q, {0, 0, std::sqrt(f) / scene_rate}, true, moving), Failure::none) << r;
            ASSERT_EQ(space.observe(ObserverKind::falling, q, true, falling), Failure::none);
            EXPECT_TRUE(moving.ingoing);
            for (int a = 0; a < 4; ++a) {
                EXPECT_NEAR(moving.offset[a], falling.offset[a], 1e-10) << keys << r;
                for (int i = 0; i < 3 && inside; ++i)
                    EXPECT_NEAR(moving.matrix[a][i], falling.matrix[a][i], 1e-10) << keys << r;
            }
        }
    }
    const auto plan = plan_of_text("[space]\nhamiltonian = \"schwarzschild\"\nrg = 1\n" + camera, {});
    const Space& space = plan->scene->space;
    StartMap map;
    EXPECT_EQ(make_moving_map(space, {0, 0, 0.5}, {0, 0, 0}, true, map), Failure::no_observer);
}

}  // namespace
}  // namespace kagero::test

// The ray list on which this program is compared with others: 2048 null rays, from 20 to 40 Schwarzschild radii past
// the hole, and how far their directions are from what elliptic integrals say. `kagero trace --json` on the same rays
// says what they cost.
#include "tests/support/greatest.h"
#include "tests/support/plan_fixture.h"
#include "tests/support/schwarzschild_orbit.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace kagero::test {
namespace {

constexpr double start_radius = 20, end_radius = 40;
const OrbitPlane plane{{2 / 3.0, -1 / 3.0, 2 / 3.0}, {2 / 3.0, 2 / 3.0, -1 / 3.0}};

/// The angle in the plane of a ray's direction where it leaves: that of its place, and tan ψ = r dφ/dr (Chandrasekhar
/// 1983, §20).
double direction_angle(double b) {
    const Orbit orbit(b);
    const double swept = 0.5 * (orbit.swept_around(start_radius) + orbit.swept_around(end_radius)), u = 1 / end_radius;
    return swept + std::atan2(u, std::sqrt(1 / (b * b) - u * u * (1 - u)));
}

/// Greatest error of direction, in radians, over impact parameters from `least`, `count` of them, `spacing` apart.
double worst_direction(const char* method, double step, double least, double spacing, int count) {
    const auto plan =
        plan_of_file(scene_file("hole.toml"),
                     {std::string("integrator.method=") + method, "integrator.step=" + std::to_string(step)},
                     with_strategy("packet"), false);
    std::vector<RayInput> rays;
    for (int k = 0; k < count; ++k)
        rays.push_back(ray_inward(plane, least + spacing * (k + 0.5), start_radius, {0, 0, 0}));
    std::vector<RayEnd> ends;
    trace(*plan, start_rays(*plan, rays), ends);
    double worst = 0;
    for (int k = 0; k < count; ++k) {
        const RayEnd& end = ends[static_cast<std::size_t>(k)];
        EXPECT_EQ(end.status, Status::escaped);
        const double angle = plane.angle_of({end.v[0], end.v[1], end.v[2]});
        worst = greatest(worst, std::abs(std::remainder(angle - direction_angle(least + spacing * (k + 0.5)),
                                                        2 * std::numbers::pi)));
    }
    return worst;
}

struct Goal {
    const char* method;
    double step, error;
};
class Peers : public testing::TestWithParam<Goal> {};

TEST_P(Peers, DirectionsAreRight) {
    const auto [method, step, error] = GetParam();
    const double worst = worst_direction(method, step, 3, 7.0 / 2048, 2048);
    RecordProperty("greatest_error", std::to_string(worst));
    EXPECT_LE(worst, error);
}
// What near-critical rays are judged by (bench/measured/rays.py), which turn many times about the hole.
TEST(PeersReference, IsRightForNearCriticalRays) {
    EXPECT_LE(worst_direction("gauss16", 0.1, 2.599, 0.021 / 2048, 2048), 2e-10);
}

INSTANTIATE_TEST_SUITE_P(Goals, Peers,
                         testing::Values(Goal{"gauss8", 0.9, 2.5e-6}, Goal{"gauss8", 0.45, 1.8e-8},
                                         Goal{"gauss12", 0.3, 1.1e-12}),
                         [](const auto& goal) {
                             return std::string(goal.param.method) + "_" + std::to_string(goal.index);
                         });

}  // namespace
}  // namespace kagero::test

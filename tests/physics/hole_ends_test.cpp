// Tests the ends of rays around black holes with different methods. Rays must hit surfaces inside the photon sphere if
// and only if their impact parameter is below the critical one. Rays that never enter the escape sphere must end at
// their perihelion, and captured rays on the horizon.
#include "tests/support/plan_fixture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace kagero::test {
namespace {

/// Returns a ray that starts at (r, 0, 0) and moves inward with the impact parameter b, for r_g = 1. Its direction
/// follows from dr/dλ = −√(1 − (1 − 1/r) b²/r²) and r dφ/dλ = b/r.
RayInput ingoing_ray(double r, double b) {
    return {{r, 0, 0}, {-std::sqrt(1 - (1 - 1 / r) * b * b / (r * r)), b / r, 0}};
}

double radius_of(const RayEnd& end) {
    return std::hypot(end.q[0], end.q[1], end.q[2]);
}

/// Pairs of settings that select a method and its step; empty strings are ignored.
constexpr const char* method_settings[][2] = {{"", ""},
                                              {"integrator.symmetry=none", ""},
                                              {"integrator.method=gauss8", ""},
                                              {"integrator.method=verlet", "integrator.step=0.02"},
                                              {"integrator.method=rkf78", "integrator.tolerance=1e-10"}};

class HoleEnds : public testing::TestWithParam<const char*> {
protected:
    std::vector<RayEnd> ends_of(const std::string& scene, const char* const (&settings)[2],
                                const std::vector<RayInput>& rays) const {
        Overrides overrides;
        for (const char* setting : settings)
            if (*setting) overrides.emplace_back(setting);
        const auto plan = plan_of_text(scene, overrides, with_strategy(GetParam()), false);
        std::vector<RayEnd> ends;
        trace(*plan, start_rays(*plan, rays), ends);
        return ends;
    }
};

// A ball inside the photon sphere is hit by exactly the rays with b < 3√3/2 r_g (Bardeen 1973).
TEST_P(HoleEnds, RaysBelowTheCriticalImpactParameterHitBallsInsideThePhotonSphere) {
    for (const double radius : {1.49, 1.3, 1.02})
        for (const auto& settings : method_settings) {
            const std::string scene =
                "space.hamiltonian = \"schwarzschild\"\n[camera]\nposition = [0, -10, 0]\nlook_at = [0, 0, 0]\nup = "
                "[0, 0, 1]\n"
                "[film]\nsize = [4, 4]\n[[object]]\nshape = \"sphere\"\ncenter = [0, 0, 0]\nradius = " +
                std::to_string(radius) + "\n";
            const double critical = 1.5 * std::numbers::sqrt3;
            std::vector<RayInput> rays;
            for (int i = 0; i < 40; ++i) rays.push_back(ingoing_ray(10, 0.075 + 0.15 * i));
            const std::vector<RayEnd> ends = ends_of(scene, settings, rays);
            for (std::size_t i = 0; i < ends.size(); ++i) {
                const double b = 0.075 + 0.15 * double(i);
                SCOPED_TRACE(testing::Message()
                             << settings[0] << " " << settings[1] << ", radius " << radius << ", b = " << b);
                ASSERT_EQ(ends[i].status, b < critical ? Status::hit : Status::escaped);
                if (b < critical) {
                    EXPECT_NEAR(radius_of(ends[i]), radius, 1e-6);
                }
            }
        }
}

// Rays that never enter the escape sphere escape at their perihelion. Its radius is the greatest root of
// r³ = b² (r − r_g) (Chandrasekhar 1983, §20).
TEST_P(HoleEnds, RaysThatMissTheEscapeSphereEndAtTheirPerihelion) {
    for (const auto& settings : method_settings) {
        const std::string scene =
            "space.hamiltonian = \"schwarzschild\"\n[integrator]\nescape_radius = 20\n[camera]\nposition = [0, -40, "
            "0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\n"
            "[film]\nsize = [4, 4]\n";
        std::vector<RayInput> rays;
        for (int i = 0; i < 17; ++i) rays.push_back(ingoing_ray(40, 21.5 + i));
        const std::vector<RayEnd> ends = ends_of(scene, settings, rays);
        for (std::size_t i = 0; i < ends.size(); ++i) {
            const double b = 21.5 + double(i);
            double r = b;
            for (int k = 0; k < 60; ++k) r = b * std::sqrt(1 - 1 / r);
            SCOPED_TRACE(testing::Message() << settings[0] << " " << settings[1] << ", b = " << b);
            ASSERT_EQ(ends[i].status, Status::escaped);
            EXPECT_NEAR(radius_of(ends[i]), r, 2e-4);
            EXPECT_NEAR(ends[i].q[0] * ends[i].v[0] + ends[i].q[1] * ends[i].v[1] + ends[i].q[2] * ends[i].v[2], 0,
                        1e-6 * r);
        }
    }
}

// Rays that are given as a list are integrated to the horizon, up to a relative distance of 0.001, or to a given λ. For
// radial rays around a Schwarzschild black hole λ is the change of r, because H = 0 implies p·x/r = −p_t. The horizon
// of Kerr's black hole is a spheroid with the half axis r₊ along the axis of rotation and √(r₊² + a²) in the equatorial
// plane.
TEST_P(HoleEnds, CapturedRaysEndOnTheHorizon) {
    const std::string view =
        "[camera]\nposition = [0, -10, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\n[film]\nsize = [4, 4]\n";
    const std::vector<RayInput> rays{{{0, 0, 10}, {0, 0, -1}},
                                     {{0, 0, 1.4}, {0, 0, -1}},
                                     ingoing_ray(10, 1),
                                     ingoing_ray(1.3, 0.4)};
    for (const auto& settings : method_settings) {
        SCOPED_TRACE(testing::Message() << settings[0] << " " << settings[1]);
        const std::vector<RayEnd> ends = ends_of("[space]\nhamiltonian = \"schwarzschild\"\n" + view, settings, rays);
        for (const RayEnd& end : ends) {
            EXPECT_EQ(end.status, Status::captured);
            EXPECT_NEAR(radius_of(end), 1.0005, 0.00051);
        }
        EXPECT_NEAR(ends[0].parameter, 10 - radius_of(ends[0]), 1e-5);
        EXPECT_NEAR(ends[1].parameter, 1.4 - radius_of(ends[1]), 1e-5);
    }
    // The limit of λ, as set by `trace --parameter`, ends a ray although its capture is already certain.
    const auto plan =
        plan_of_text("[space]\nhamiltonian = \"schwarzschild\"\n" + view,
                     {"integrator.symmetry=none", "integrator.rescale=none"}, with_strategy(GetParam()), false);
    plan->run.parameter_limit = 8.7;
    std::vector<RayEnd> limited;
    trace(*plan, start_rays(*plan, {rays[0]}), limited);
    EXPECT_EQ(limited[0].status, Status::step_limit);
    EXPECT_EQ(limited[0].parameter, 8.7);
    EXPECT_NEAR(limited[0].q[2], 1.3, 1e-9);
    for (const double spin : {0.6, 0.99, 1.0}) {
        SCOPED_TRACE(spin);
        const double a = 0.5 * spin, horizon = 0.5 + std::sqrt(0.25 - a * a), equator = std::hypot(horizon, a);
        const std::string kerr =
            "[space]\nhamiltonian = \"kerr\"\nmass = 0.5\nspin = " + std::to_string(spin) + "\n" + view;
        for (const RayEnd& end : ends_of(kerr, {"", ""}, rays)) {
            EXPECT_EQ(end.status, Status::captured);
            EXPECT_NEAR(std::hypot(std::hypot(end.q[0], end.q[1]) / equator, end.q[2] / horizon), 1.0005, 0.00051);
        }
    }
}

// Without time rescaling, a fixed step that is efficient far from a hole is too long near it. The default is therefore
// an adaptive method, which is compared with a fixed short step.
TEST(HoleEndsWithoutRescaling, DefaultMatchesFineSteps) {
    const std::string scene =
        "[space]\nhamiltonian = \"schwarzschild\"\nrg = 0.08\n[integrator]\nrescale = \"none\"\nescape_radius = 4\n"
        "[camera]\nposition = [0, -10, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\n[film]\nsize = [4, 4]\n";
    const std::vector<RayInput> rays{{{-0.9, 0.3, 0}, {1, 0, 0}},
                                     {{-0.9, 0.25, 0}, {1, 0, 0}},
                                     {{-0.9, 0.22, 0.1}, {1, 0, 0}}};
    const auto ends_of = [&](const Overrides& overrides) {
        const auto plan = plan_of_text(scene, overrides, {}, false);
        std::vector<RayEnd> ends;
        trace(*plan, start_rays(*plan, rays), ends);
        return ends;
    };
    const auto ends = ends_of({}), fine = ends_of({"integrator.method=gauss16", "integrator.step=0.005"});
    for (std::size_t i = 0; i < rays.size(); ++i) {
        ASSERT_EQ(ends[i].status, Status::escaped) << i;
        for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(ends[i].q[k], fine[i].q[k], 1e-5) << i;
    }
}

INSTANTIATE_TEST_SUITE_P(Strategies, HoleEnds, testing::Values("scalar", "packet"));

}  // namespace
}  // namespace kagero::test

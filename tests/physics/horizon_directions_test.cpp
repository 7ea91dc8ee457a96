// Tests the final directions of rays that start close to a horizon, where their momentum is large. Rays with the
// default method and step are compared with rays by other methods with smaller steps.
#include "tests/support/plan_fixture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

namespace kagero::test {
namespace {

std::vector<RayEnd> ends_of(const Plan& plan, const std::vector<RayStart>& starts) {
    std::vector<RayEnd> ends;
    trace(plan, starts, ends);
    return ends;
}

/// Returns the length of the difference of the unit directions of two ray ends.
double direction_difference(const RayEnd& a, const RayEnd& b) {
    return std::hypot(a.v[0] - b.v[0], a.v[1] - b.v[1], a.v[2] - b.v[2]);
}

// Near the horizon r₊, outgoing light has p ∝ 1/(r − r₊), so that the default step must decrease with r − r₊.
// The reference is an adaptive method with the tolerance 1e-12.
TEST(Kerr, DirectionsFromNearTheHorizonMatchAFineStep) {
    for (const double spin : {0.5, 0.9}) {
        const std::string space = "space = { hamiltonian = \"kerr\", spin = " + std::to_string(spin) + " }\n";
        const std::string other_settings =
            "escape_radius = 30\nmax_steps = 1000000\n[camera]\nposition = [0, -10, 0]\nlook_at = [0, 0, 0]\n"
            "up = [0, 0, 1]\n[film]\nsize = [4, 4]\n";
        const auto plan = plan_of_text(space + "[integrator]\n" + other_settings, {}, with_strategy("packet"), false);
        const auto fine =
            plan_of_text(space + "[integrator]\nmethod = \"dp54\"\ntolerance = 1e-12\nstep = 0.001\n" + other_settings,
                         {}, with_strategy("packet"), false);
        for (const double height : {0.1, 0.01}) {  // height above the horizon, in units of r₊
            const double r = (1 + std::sqrt(1 - spin * spin)) * (1 + height);
            std::vector<RayInput> rays;
            for (const double theta : {0.35, 1.05, std::numbers::pi / 2})
                for (int i = 0; i < 40; ++i) {
                    // rho: distance of the start from the axis of rotation.
                    const double rho = std::hypot(r, spin) * std::sin(theta), z = 1 - (i + 0.5) / 20,
                                 azimuth = 2.399963 * i;
                    const double s = std::sqrt(1 - z * z);
                    rays.push_back({{rho * std::cos(0.3), rho * std::sin(0.3), r * std::cos(theta)},
                                    {s * std::cos(azimuth), s * std::sin(azimuth), z}});
                }
            const auto ends = ends_of(*plan, start_rays(*plan, rays, ObserverKind::zamo)),
                       expected = ends_of(*fine, start_rays(*fine, rays, ObserverKind::zamo));
            std::vector<double> errors;
            for (std::size_t i = 0; i < rays.size(); ++i) {
                ASSERT_EQ(ends[i].status, expected[i].status)
                    << "spin " << spin << ", height " << height << ", ray " << i;
                if (ends[i].status != Status::escaped) continue;
                errors.push_back(direction_difference(ends[i], expected[i]));
            }
            ASSERT_GE(errors.size(), 3u);
            std::sort(errors.begin(), errors.end());
            EXPECT_LT(errors[errors.size() / 2], 1e-6) << "spin " << spin << ", height " << height;
            // The greatest error is that of a ray that circles the hole, because circling amplifies all errors.
            EXPECT_LT(errors.back(), 1e-3) << "spin " << spin << ", height " << height;
        }
    }
}

// The default method of the general path is compared with the default method in the orbit plane. Near the horizon,
// p ∝ 1/(r − r_g).
TEST(Schwarzschild, DirectionsFromNearTheHorizonMatchTheOrbitPlane) {
    for (const double r : {1.01, 1.03, 1.1, 1.3, 1.5}) {
        std::ostringstream scene;
        scene << "[space]\nhamiltonian = \"schwarzschild\"\n[integrator]\nescape_radius = 60\n[camera]\nposition = [0, "
              << -r << ", 0]\nlook_at = [0, -9, 0.2]\nup = [0, 0, 1]\nfov = 90\n[film]\nsize = [40, 30]\n";
        const auto orbit_plane = plan_of_text(scene.str(), {}, with_strategy("packet")),
                   general_path = plan_of_text(scene.str(), {"integrator.symmetry=none"}, with_strategy("packet"));
        ASSERT_NE(orbit_plane->method().name, general_path->method().name);
        std::vector<RayStart> starts;
        for (std::uint32_t i = 0; i < 40 * 30; ++i) starts.push_back(pixel_ray_start(*orbit_plane, i % 40, i / 40));
        const auto expected = ends_of(*orbit_plane, starts), ends = ends_of(*general_path, starts);
        int different_status = 0;
        std::vector<double> errors;
        for (std::size_t i = 0; i < ends.size(); ++i) {
            different_status += ends[i].status != expected[i].status;
            if (ends[i].status == Status::escaped && expected[i].status == Status::escaped)
                errors.push_back(direction_difference(ends[i], expected[i]));
        }
        ASSERT_GE(errors.size(), 20u) << r;
        std::sort(errors.begin(), errors.end());
        EXPECT_LT(errors[errors.size() / 2], 5e-4) << r;
        EXPECT_LT(errors.back(), 0.25 * 2 / 30) << r;  // a quarter of a pixel; 30 pixels span 90°
        EXPECT_LE(different_status, 2) << r;
    }
}

}  // namespace
}  // namespace kagero::test

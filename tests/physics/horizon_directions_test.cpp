// Directions of light that leaves from close to a horizon, where its momentum is large: the defaults against smaller
// steps and another way.
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

/// Of unit directions.
double apart(const RayEnd& a, const RayEnd& b) {
    return std::hypot(a.v[0] - b.v[0], a.v[1] - b.v[1], a.v[2] - b.v[2]);
}

// Light that leaves the horizon's neighbourhood has p ∝ 1/(r − r₊): the default step must shrink with that distance.
// The reference controls its own steps.
TEST(Kerr, DirectionsFromCloseToTheHorizonAreRight) {
    for (const double spin : {0.5, 0.9}) {
        const std::string space = "space = { hamiltonian = \"kerr\", spin = " + std::to_string(spin) + " }\n";
        const std::string rest =
            "escape_radius = 30\nmax_steps = 1000000\n[camera]\nposition = [0, -10, 0]\nlook_at = [0, 0, 0]\n"
            "up = [0, 0, 1]\n[film]\nsize = [4, 4]\n";
        const auto plan = plan_of_text(space + "[integrator]\n" + rest, {}, with_strategy("packet"), false);
        const auto careful =
            plan_of_text(space + "[integrator]\nmethod = \"dp54\"\ntolerance = 1e-12\nstep = 0.001\n" + rest, {},
                         with_strategy("packet"), false);
        for (const double height : {0.1, 0.01}) {  // above the horizon, in its radii
            const double r = (1 + std::sqrt(1 - spin * spin)) * (1 + height);
            std::vector<RayInput> rays;
            for (const double theta : {0.35, 1.05, std::numbers::pi / 2})
                for (int i = 0; i < 40; ++i) {
                    const double across = std::hypot(r, spin) * std::sin(theta), z = 1 - (i + 0.5) / 20,
                                 turn = 2.399963 * i;
                    const double s = std::sqrt(1 - z * z);
                    rays.push_back({{across * std::cos(0.3), across * std::sin(0.3), r * std::cos(theta)},
                                    {s * std::cos(turn), s * std::sin(turn), z}});
                }
            const auto ends = ends_of(*plan, start_rays(*plan, rays, ObserverKind::zamo)),
                       expected = ends_of(*careful, start_rays(*careful, rays, ObserverKind::zamo));
            std::vector<double> off;
            for (std::size_t i = 0; i < rays.size(); ++i) {
                ASSERT_EQ(ends[i].status, expected[i].status)
                    << "spin " << spin << ", height " << height << ", ray " << i;
                if (ends[i].status != Status::escaped) continue;
                off.push_back(apart(ends[i], expected[i]));
            }
            ASSERT_GE(off.size(), 3u);
            std::sort(off.begin(), off.end());
            EXPECT_LT(off[off.size() / 2], 1e-6) << "spin " << spin << ", height " << height;
            EXPECT_LT(off.back(), 1e-3) << "spin " << spin << ", height "
                                        << height;  // it circles the hole, and magnifies every error
        }
    }
}

// The default off the plane of the orbit, against that in it, from where p ∝ 1/(r − r_g): what escapes does so in the
// same direction.
TEST(Schwarzschild, DirectionsFromCloseToTheHorizonAreRight) {
    for (const double r : {1.01, 1.03, 1.1, 1.3, 1.5}) {
        std::ostringstream scene;
        scene << "[space]\nhamiltonian = \"schwarzschild\"\n[integrator]\nescape_radius = 60\n[camera]\nposition = [0, "
              << -r << ", 0]\nlook_at = [0, -9, 0.2]\nup = [0, 0, 1]\nfov = 90\n[film]\nsize = [40, 30]\n";
        const auto in_plane = plan_of_text(scene.str(), {}, with_strategy("packet")),
                   off_plane = plan_of_text(scene.str(), {"integrator.symmetry=none"}, with_strategy("packet"));
        ASSERT_NE(in_plane->method().name, off_plane->method().name);
        std::vector<RayStart> starts;
        for (std::uint32_t i = 0; i < 40 * 30; ++i) starts.push_back(pixel_ray(*in_plane, i % 40, i / 40));
        const auto expected = ends_of(*in_plane, starts), ends = ends_of(*off_plane, starts);
        int other = 0;
        std::vector<double> off;
        for (std::size_t i = 0; i < ends.size(); ++i) {
            other += ends[i].status != expected[i].status;
            if (ends[i].status == Status::escaped && expected[i].status == Status::escaped)
                off.push_back(apart(ends[i], expected[i]));
        }
        ASSERT_GE(off.size(), 20u) << r;
        std::sort(off.begin(), off.end());
        EXPECT_LT(off[off.size() / 2], 5e-4) << r;
        EXPECT_LT(off.back(), 0.25 * 2 / 30) << r;  // a quarter of a pixel, of which there are 30 to 90 degrees
        EXPECT_LE(other, 2) << r;
    }
}

}  // namespace
}  // namespace kagero::test

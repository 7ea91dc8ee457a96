// Compares positions and directions of hits near a Schwarzschild black hole with elliptic integrals. The position of a
// hit on the chord of a step must have order 2. Refined hits must have the order of the method.
#include "tests/support/plan_fixture.h"
#include "tests/support/schwarzschild_orbit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

namespace kagero::test {
namespace {

constexpr double start_radius = 20, ball_radius = 3;

/// A ball around the hole, which rays hit before their turning point.
constexpr const char* ball = "name = \"ball\"\nshape = \"sphere\"\ncenter = [0, 0, 0]\nradius = 3\n";
/// A rectangle in the plane x = 0 through the centre of the hole. The rays start on the x axis.
constexpr const char* plane =
    "name = \"plane\"\nshape = \"rectangle\"\norigin = [0, -16, -15]\nedge_u = [0, 31, 0]\nedge_v = [0, 0, 32]\n";

/// Position of a hit in polar coordinates of the orbit plane, and dq/dλ at the hit. The ray starts at the angle 0.
struct Hit {
    double radius, angle;
    Velocity velocity;
};
/// Returns the exact hit of a ray with the impact parameter b on the ball or on the plane.
Hit exact_hit(bool on_ball, double b) {
    if (on_ball) return {ball_radius, swept_by_quadrature(b, start_radius, ball_radius), ingoing(b, ball_radius)};
    const Orbit orbit(b);
    const double angle = std::numbers::pi / 2;
    return {orbit.radius_after(start_radius, angle), angle, orbit.velocity_after(start_radius, angle)};
}

/// Errors of hits: root mean squares of position and direction, and the greatest distance from the surface.
struct Errors {
    double position, direction, off_surface;
};

/// Returns the errors of the hits of 100 rays. The mean is needed because the error of one ray depends on the position
/// of the hit within its step.
Errors errors(const std::string& strategy, bool on_ball, const char* method, const char* hit, double step) {
    const auto plan = plan_of_text(scene_text("hole.toml") + "[[object]]\n" + (on_ball ? ball : plane),
                                   {"integrator.escape_radius=25", std::string("integrator.method=") + method,
                                    std::string("integrator.hit=") + hit, "integrator.step=" + std::to_string(step)},
                                   with_strategy(strategy), false);
    const OrbitPlane orbit_plane{{1, 0, 0}, {0, 0.8, 0.6}};
    std::vector<RayInput> rays;
    std::vector<double> impact;
    for (int i = 0; i < 100; ++i) {
        // The rays hit the ball before their turning points, or pass the hole at a distance and hit the plane.
        impact.push_back((on_ball ? 2.1 : 5) + 0.0125 * i);
        rays.push_back(ray_inward(orbit_plane, impact.back(), start_radius, {0, 0, 0}));
    }
    std::vector<RayEnd> ends;
    trace(*plan, start_rays(*plan, rays), ends);
    Errors sum{0, 0, 0};
    for (std::size_t i = 0; i < ends.size(); ++i) {
        EXPECT_EQ(ends[i].status, Status::hit) << method << " b = " << impact[i];
        EXPECT_FALSE(ends[i].unrefined);
        const auto [radius, angle, v] = exact_hit(on_ball, impact[i]);
        const double c = std::cos(angle), s = std::sin(angle), speed = std::hypot(v.radial, v.transverse);
        const Double3 q = orbit_plane.at(radius * c, radius * s);
        const Double3 d =
            orbit_plane.at((v.radial * c - v.transverse * s) / speed, (v.radial * s + v.transverse * c) / speed);
        for (std::size_t k = 0; k < 3; ++k) {
            sum.position += std::pow(ends[i].q[k] - q[k], 2);
            sum.direction += std::pow(ends[i].v[k] - d[k], 2);
        }
        const double off = on_ball ? std::hypot(ends[i].q[0], ends[i].q[1], ends[i].q[2]) - ball_radius : ends[i].q[0];
        sum.off_surface = std::max(sum.off_surface, std::abs(off));
    }
    const double n = static_cast<double>(ends.size());
    return {std::sqrt(sum.position / n), std::sqrt(sum.direction / n), sum.off_surface};
}

// The speed of a ray varies along a long step. The hit on a small ball must nevertheless be the first intersection,
// where the velocity points into the ball.
TEST(Hits, OnSmallBallsAreOnTheNearSide) {
    struct View {
        const char *space, *camera, *look_at, *center;
        double radius;
    };
    constexpr const char *before_hole = "[0.3, -6, 0.2]", *near_ball = "[-0.24, -3.3, 0.45]";
    // A camera ray in the direction of `bent_towards` is bent by the hole and hits the ball at `far_ball`.
    constexpr const char *beside_hole = "[0, -6, 0]", *bent_towards = "[8.69, -0.545, 0]", *far_ball = "[16, 13, 0]";
    const View views[] = {{"hamiltonian = \"wormhole\"\nthroat = 0.1", before_hole, near_ball, near_ball, 0.19},
                          {"hamiltonian = \"schwarzschild\"\nrg = 0.05", before_hole, near_ball, near_ball, 0.19},
                          {"hamiltonian = \"kerr\"\nmass = 0.025", before_hole, near_ball, near_ball, 0.19},
                          {"hamiltonian = \"schwarzschild\"\nrg = 1", beside_hole, bent_towards, far_ball, 0.2},
                          {"hamiltonian = \"schwarzschild\"\nrg = 1", beside_hole, bent_towards, far_ball, 0.4},
                          {"hamiltonian = \"schwarzschild\"\nrg = 1", beside_hole, bent_towards, far_ball, 1.5}};
    for (const auto& [space, camera, look_at, center, radius] : views)
        for (const char* symmetry : {"auto", "none"})
            for (const char* strategy : {"packet", "scalar"}) {
                std::ostringstream text;
                text << "[space]\n"
                     << space << "\n[integrator]\nescape_radius = 60\nsymmetry = \"" << symmetry
                     << "\"\n[camera]\nposition = " << camera << "\nlook_at = " << look_at
                     << "\nup = [0, 0, 1]\nfov = " << (look_at == center ? 8 : 2) << "\n[film]\nsize = [32, 32]\n"
                     << "[[object]]\nshape = \"sphere\"\ncenter = " << center << "\nradius = " << radius << "\n"
                     << "[[object]]\nshape = \"room\"\nmin = [-30, -30, -30]\nmax = [30, 30, 30]\n";
                const auto plan = plan_of_text(text.str(), {}, with_strategy(strategy));
                std::vector<RayStart> starts;
                for (std::uint32_t i = 0; i < 32 * 32; ++i) starts.push_back(pixel_ray_start(*plan, i % 32, i / 32));
                std::vector<RayEnd> ends;
                trace(*plan, starts, ends);
                const Double3& c = plan->description().objects[0].center;
                int hits = 0;
                for (const RayEnd& end : ends) {
                    if (end.status != Status::hit || end.surface != 0) continue;
                    ++hits;
                    double outward_speed = 0;
                    for (std::size_t k = 0; k < 3; ++k) outward_speed += (end.q[k] - c[k]) * end.v[k];
                    EXPECT_LT(outward_speed, 1e-3) << text.str() << strategy;
                }
                EXPECT_GT(hits, 100) << text.str();
            }
}

class HitOrder : public testing::TestWithParam<std::tuple<const char*, bool>> {
protected:
    /// Orders of convergence, and the errors with the fine step.
    struct Orders {
        double position, direction;
        Errors fine;
    };
    /// Returns the orders between the step sizes 0.2 and 0.05 in τ, where dλ = r dτ. The errors with the fine step are
    /// far above rounding.
    static Orders measured_orders(const char* method, const char* hit) {
        const auto [strategy, on_ball] = GetParam();
        const Errors coarse = errors(strategy, on_ball, method, hit, 0.2),
                     fine = errors(strategy, on_ball, method, hit, 0.05);
        return {0.5 * std::log2(coarse.position / fine.position), 0.5 * std::log2(coarse.direction / fine.direction),
                fine};
    }
    /// Tolerance of measured orders. Error terms of higher order contribute to the coarse error, rounding errors to the
    /// fine error.
    static constexpr double tolerance = 0.5;
    /// Rounding error of a coordinate of size 20, the radius at the start of the rays.
    static constexpr double rounding = 20 * std::numeric_limits<double>::epsilon();
};

// A fisheye focuses light, so that a chord may miss an object that the ray hits, although the chord deviates from the
// ray by a small fraction of a pixel. Status and object with long steps are compared with those of short steps; at most
// 0.2 % of the rays may differ.
TEST(Hits, ObjectsInAFisheyeMatchShortSteps) {
    const std::string scene = KAGERO_SCENES "/fisheye.toml";
    for (const char* size : {"film.size=[18,12]", "film.size=[60,40]"}) {
        const auto ends = [&](const Overrides& overrides) {
            Overrides settings{size, "integrator.symmetry=none", "integrator.method=dp54"};
            settings.insert(settings.end(), overrides.begin(), overrides.end());
            const auto plan = plan_of_file(scene, settings, with_strategy("packet"));
            std::vector<RayStart> starts;
            for (std::uint32_t y = 0; y < plan->description().film.height; ++y)
                for (std::uint32_t x = 0; x < plan->description().film.width; ++x)
                    starts.push_back(pixel_ray_start(*plan, x, y));
            std::vector<RayEnd> found;
            trace(*plan, starts, found);
            return found;
        };
        const auto long_steps = ends({}), short_steps = ends({"integrator.method=rkf78", "integrator.tolerance=1e-14"});
        std::size_t different = 0;
        for (std::size_t i = 0; i < long_steps.size(); ++i) {
            EXPECT_NE(long_steps[i].status, Status::failed) << describe(long_steps[i].failure);
            different +=
                long_steps[i].status != short_steps[i].status || long_steps[i].surface != short_steps[i].surface;
        }
        EXPECT_LE(different, long_steps.size() / 500) << size;
    }
}

TEST_P(HitOrder, IsTwoOnChordsForAllMethods) {
    for (const char* method : {"rk4", "suzuki4-nine", "gauss4", "gauss12"}) {
        SCOPED_TRACE(method);
        const Orders found = measured_orders(method, "chord");
        EXPECT_NEAR(found.position, 2, tolerance);
        EXPECT_NEAR(found.direction, 1, tolerance);
        EXPECT_LT(found.fine.off_surface, rounding);
    }
}

TEST_P(HitOrder, IsThatOfTheMethodForRefinedHits) {
    constexpr std::pair<const char*, int> methods[] = {
        {"verlet", 2}, {"rk4", 4}, {"suzuki4-nine", 4}, {"gauss4", 4}, {"gauss6", 6}};
    for (const auto& [method, order] : methods) {
        SCOPED_TRACE(method);
        const Orders found = measured_orders(method, "hermite");
        EXPECT_GT(found.position, order - tolerance) << found.fine.position;
        EXPECT_GT(found.direction, order - tolerance) << found.fine.direction;
        EXPECT_LT(found.fine.off_surface, rounding);
    }
}

// With a method of order 16 only the sum of the rounding errors of all steps remains.
TEST_P(HitOrder, HitsAreExactToRoundingWithAMethodOfHighOrder) {
    const auto [strategy, on_ball] = GetParam();
    const Errors found = errors(strategy, on_ball, "gauss16", "hermite", 0.05);
    EXPECT_LT(found.position, 100 * rounding);
    EXPECT_LT(found.direction, 100 * rounding);
}

INSTANTIATE_TEST_SUITE_P(Surfaces, HitOrder, testing::Combine(testing::Values("packet", "scalar"), testing::Bool()),
                         [](const auto& chosen) {
                             return std::string(std::get<0>(chosen.param)) +
                                    (std::get<1>(chosen.param) ? "_ball" : "_plane");
                         });

}  // namespace
}  // namespace kagero::test

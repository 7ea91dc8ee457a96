// Where a bent ray meets a surface, against elliptic integrals: a chord throws the order of the method away, refinement
// keeps it.
#include "tests/support/plan_fixture.h"
#include "tests/support/schwarzschild_orbit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

namespace kagero::test {
namespace {

constexpr double start_radius = 20, ball_radius = 3;

/// A ball around the hole, reached before rays turn back; and a plane through the centre, across the direction of the
/// start.
constexpr const char* ball = "name = \"ball\"\nshape = \"sphere\"\ncenter = [0, 0, 0]\nradius = 3\n";
constexpr const char* plane =
    "name = \"plane\"\nshape = \"rectangle\"\norigin = [0, -16, -15]\nedge_u = [0, 31, 0]\nedge_v = [0, 0, 32]\n";

/// The hit of a ray with impact parameter b that starts on the axis of `outward`, in its orbital plane, and dq/dλ
/// there.
struct Hit {
    double radius, angle;
    Velocity velocity;
};
Hit exact_hit(bool on_ball, double b) {
    if (on_ball) return {ball_radius, swept_by_quadrature(b, start_radius, ball_radius), ingoing(b, ball_radius)};
    const Orbit orbit(b);
    const double angle = std::numbers::pi / 2;
    return {orbit.radius_after(start_radius, angle), angle, orbit.velocity_after(start_radius, angle)};
}

struct Errors {
    double position, direction, off_surface;
};

/// Root mean squares over impact parameters: one ray's error depends on where in its step it hits.
Errors errors(const std::string& strategy, bool on_ball, const char* method, const char* hit, double step) {
    const auto plan = plan_of_text(scene_text("hole.toml") + "[[object]]\n" + (on_ball ? ball : plane),
                                   {"integrator.escape_radius=25", std::string("integrator.method=") + method,
                                    std::string("integrator.hit=") + hit, "integrator.step=" + std::to_string(step)},
                                   with_strategy(strategy), false);
    const OrbitPlane tilted{{1, 0, 0}, {0, 0.8, 0.6}};
    std::vector<RayInput> rays;
    std::vector<double> impact;
    for (int i = 0; i < 100; ++i) {
        // From the ball's middle to nine tenths of where rays pass it; well off the hole for the plane.
        impact.push_back((on_ball ? 2.1 : 5) + 0.0125 * i);
        rays.push_back(ray_inward(tilted, impact.back(), start_radius, {0, 0, 0}));
    }
    std::vector<RayEnd> ends;
    trace(*plan, start_rays(*plan, rays), ends);
    Errors sum{0, 0, 0};
    for (std::size_t i = 0; i < ends.size(); ++i) {
        EXPECT_EQ(ends[i].status, Status::hit) << method << " b = " << impact[i];
        EXPECT_FALSE(ends[i].unrefined);
        const auto [radius, angle, v] = exact_hit(on_ball, impact[i]);
        const double c = std::cos(angle), s = std::sin(angle), speed = std::hypot(v.along, v.aside);
        const Double3 q = tilted.at(radius * c, radius * s);
        const Double3 d = tilted.at((v.along * c - v.aside * s) / speed, (v.along * s + v.aside * c) / speed);
        for (std::size_t k = 0; k < 3; ++k) {
            sum.position += std::pow(ends[i].q[k] - q[k], 2), sum.direction += std::pow(ends[i].v[k] - d[k], 2);
        }
        const double off = on_ball ? std::hypot(ends[i].q[0], ends[i].q[1], ends[i].q[2]) - ball_radius : ends[i].q[0];
        sum.off_surface = std::max(sum.off_surface, std::abs(off));
    }
    const double n = static_cast<double>(ends.size());
    return {std::sqrt(sum.position / n), std::sqrt(sum.direction / n), sum.off_surface};
}

// A long step goes fast here and slowly there: the far side of a small ball must not be taken for the near one. From
// outside a ball is met where rays go inward.
TEST(Hits, OfSmallBallsAreOnTheirNearSide) {
    struct View {
        const char *space, *camera, *look_at, *center;
        double radius;
    };
    constexpr const char *before_hole = "[0.3, -6, 0.2]", *near_ball = "[-0.24, -3.3, 0.45]";
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
                for (std::uint32_t i = 0; i < 32 * 32; ++i) starts.push_back(pixel_ray(*plan, i % 32, i / 32));
                std::vector<RayEnd> ends;
                trace(*plan, starts, ends);
                const Double3& c = plan->description().objects[0].center;
                int balls = 0;
                for (const RayEnd& end : ends) {
                    if (end.status != Status::hit || end.surface != 0) continue;
                    ++balls;
                    double inward = 0;
                    for (std::size_t k = 0; k < 3; ++k) inward += (end.q[k] - c[k]) * end.v[k];
                    EXPECT_LT(inward, 1e-3) << text.str() << strategy;
                }
                EXPECT_GT(balls, 100) << text.str();
            }
}

class HitOrder : public testing::TestWithParam<std::tuple<const char*, bool>> {
protected:
    struct Slopes {
        double position, direction;
        Errors finest;
    };
    /// Orders from a step to a quarter of it, a fifth of the radius long at first: still far above rounding at the end.
    static Slopes slopes(const char* method, const char* hit) {
        const auto [strategy, on_ball] = GetParam();
        const Errors coarse = errors(strategy, on_ball, method, hit, 0.2),
                     fine = errors(strategy, on_ball, method, hit, 0.05);
        return {0.5 * std::log2(coarse.position / fine.position), 0.5 * std::log2(coarse.direction / fine.direction),
                fine};
    }
    /// Fitted over a factor of four, an order is good to a half: the next one adds to the coarse error, roundings to
    /// the fine.
    static constexpr double half = 0.5;
    /// A hit stands on its surface to a few roundings of a coordinate, 20 at the start of the ray's coordinates and
    /// less here.
    static constexpr double rounding = 20 * std::numeric_limits<double>::epsilon();
};

// Where light is focused a chord that is a small part of a pixel off may miss what its ray hits, and however small the
// picture: objects are those of short steps.
TEST(Hits, AreTheRightOnesInAFisheye) {
    const std::string scene = KAGERO_SCENES "/fisheye.toml";
    for (const char* size : {"film.size=[18,12]", "film.size=[60,40]"}) {
        const auto ends = [&](const Overrides& more) {
            Overrides all{size, "integrator.symmetry=none", "integrator.method=dp54"};
            all.insert(all.end(), more.begin(), more.end());
            const auto plan = plan_of_file(scene, all, with_strategy("packet"));
            std::vector<RayStart> starts;
            for (std::uint32_t y = 0; y < plan->description().film.height; ++y)
                for (std::uint32_t x = 0; x < plan->description().film.width; ++x)
                    starts.push_back(pixel_ray(*plan, x, y));
            std::vector<RayEnd> found;
            trace(*plan, starts, found);
            return found;
        };
        const auto long_steps = ends({}), short_steps = ends({"integrator.method=rkf78", "integrator.tolerance=1e-14"});
        std::size_t others = 0;
        for (std::size_t i = 0; i < long_steps.size(); ++i) {
            EXPECT_NE(long_steps[i].status, Status::failed) << describe(long_steps[i].failure);
            others += long_steps[i].status != short_steps[i].status || long_steps[i].surface != short_steps[i].surface;
        }
        EXPECT_LE(others, long_steps.size() / 500) << size;
    }
}

TEST_P(HitOrder, OfAChordIsTwoWhateverTheMethod) {
    for (const char* method : {"rk4", "suzuki4-nine", "gauss4", "gauss12"}) {
        SCOPED_TRACE(method);
        const Slopes order = slopes(method, "chord");
        EXPECT_NEAR(order.position, 2, half);
        EXPECT_NEAR(order.direction, 1, half);
        EXPECT_LT(order.finest.off_surface, rounding);
    }
}

TEST_P(HitOrder, OfARefinedHitIsTheMethods) {
    constexpr std::pair<const char*, int> methods[] = {
        {"verlet", 2}, {"rk4", 4}, {"suzuki4-nine", 4}, {"gauss4", 4}, {"gauss6", 6}};
    for (const auto& [method, order] : methods) {
        SCOPED_TRACE(method);
        const Slopes found = slopes(method, "hermite");
        EXPECT_GT(found.position, order - half) << found.finest.position;
        EXPECT_GT(found.direction, order - half) << found.finest.direction;
        EXPECT_LT(found.finest.off_surface, rounding);
    }
}

// With a method of high order the hit is exact: what remains are roundings along the way, of 20 per coordinate and
// step.
TEST_P(HitOrder, LeavesRoundingAlone) {
    const auto [strategy, on_ball] = GetParam();
    const Errors left = errors(strategy, on_ball, "gauss16", "hermite", 0.05);
    EXPECT_LT(left.position, 100 * rounding);
    EXPECT_LT(left.direction, 100 * rounding);
}

INSTANTIATE_TEST_SUITE_P(Surfaces, HitOrder, testing::Combine(testing::Values("packet", "scalar"), testing::Bool()),
                         [](const auto& chosen) {
                             return std::string(std::get<0>(chosen.param)) +
                                    (std::get<1>(chosen.param) ? "_ball" : "_plane");
                         });

}  // namespace
}  // namespace kagero::test

// Tests what a falling observer sees on its way into a hole.
#include "tests/support/kerr_rays.h"

#include <gtest/gtest.h>
#include <boost/math/quadrature/tanh_sinh.hpp>

#include <cmath>
#include <numbers>

namespace kagero::test {
namespace {

/// An object inside the horizon, and a camera that is deeper inside, in ingoing coordinates.
struct InnerObject {
    std::string text;
    double spin;
    Double3 camera;
    Beyond beyond;  ///< The signed distance from the surface, which is negative at the camera.
};

/// Returns a ball in the way of the ray in the direction d of the falling camera's frame, where the ray is at radius r.
InnerObject ball_in_direction(double spin, const Double3& camera, const Double3& d, double r, double radius) {
    const auto plan = plan_for_rays(scene_with_hole(spin), "falling");
    const KerrGeodesic ray = geodesic_of(*plan, start_rays(*plan, {{camera, d}}, ObserverKind::falling)[0]);
    const Hole hole = plan->scene->space.hole();
    const auto beyond_radius = [&](const Real(&q)[3]) {
        const double position[3] = {double(q[0]), double(q[1]), double(q[2])};
        return Real(plan->module().hole_radius(&hole, position)) - r;
    };
    KerrGeodesic::Place place;
    EXPECT_TRUE(ray.follow(beyond_radius, 0.1L, place));
    std::string text = "[[object]]\nshape = \"sphere\"\nradius = " + std::to_string(radius) + "\ncenter = [";
    double center[3];
    for (std::size_t k = 0; k < 3; ++k) {
        const std::string number = std::to_string(double(place.q[k]));
        text += (k > 0 ? ", " : "") + number;
        center[k] = std::stod(number);
    }
    return {text + "]\n", spin, camera, [=](const Real(&q)[3]) {
                return radius - std::hypot(q[0] - center[0], q[1] - center[1], q[2] - center[2]);
            }};
}

/// Returns balls, the vertical rectangle x = 1, and the horizontal rectangle z = 0.9.
std::vector<InnerObject> inner_objects() {
    const std::string wall =
                          "[[object]]\nshape = \"rectangle\"\norigin = [1, -0.3, -0.3]\nedge_u = [0, 0.6, 0]\n"
                          "edge_v = [0, 0, 0.6]\n",
                      ceiling =
                          "[[object]]\nshape = \"rectangle\"\norigin = [-0.3, -0.3, 0.9]\nedge_u = [0.6, 0, 0]\n"
                          "edge_v = [0, 0.6, 0]\n";
    return {ball_in_direction(0, {0.4, 0.1, 0.2}, {1, 0.2, 0.1}, 1.4, 0.2),
            ball_in_direction(0.9, position_at(0.9, 0.8, 1.2, 0.7), {1, 1, 0.5}, 1.15, 0.1),
            ball_in_direction(-0.6, position_at(-0.6, 0.7, 0.5, 2.0), {-1, 0.5, 1}, 1.3, 0.15),
            {wall, 0, {0.4, 0.1, 0.1}, [](const Real(&q)[3]) { return q[0] - 1; }},
            {ceiling, 0.9, position_at(0.9, 0.7, 0.2, 0.3), [](const Real(&q)[3]) { return q[2] - 0.9L; }}};
}

class FallingCamera : public testing::TestWithParam<const char*> {};

TEST_P(FallingCamera, SeesObjectsInsideTheHorizon) {
    for (const InnerObject& object : inner_objects()) {
        SCOPED_TRACE(testing::Message() << object.text << "spin " << object.spin);
        const auto plan = plan_for_rays(scene_with_hole(object.spin, object.text), "falling", GetParam());
        std::vector<RayInput> rays;
        for (const Double3& d : even_directions(600)) rays.push_back({object.camera, d});
        const auto starts = start_rays(*plan, rays, ObserverKind::falling);
        const auto ends = traced(*plan, starts);
        int hits = 0;
        for (std::size_t i = 0; i < ends.size(); ++i) {
            const RayEnd& end = ends[i];
            if (end.status != Status::hit) continue;
            ++hits;
            const KerrGeodesic ray = geodesic_of(*plan, starts[i]);
            // The printed p_t of a ray that starts inside the horizon is that of the time-reversed form.
            const KerrGeodesic at_hit(object.spin, end.q, end.p, -end.pt, true);
            EXPECT_EQ(ray.E, at_hit.E);
            EXPECT_NEAR(double(at_hit.L), double(ray.L), 1e-9 * (1 + std::abs(double(ray.L)))) << i;
            EXPECT_NEAR(double(at_hit.Q), double(ray.Q), 1e-9 * (1 + std::abs(double(ray.Q)))) << i;
            const Real q[3] = {end.q[0], end.q[1], end.q[2]};
            EXPECT_NEAR(double(object.beyond(q)), 0, 1e-12) << i;
            KerrGeodesic::Place expected;
            ASSERT_TRUE(ray.follow(object.beyond, 0.001L, expected)) << i;
            EXPECT_LT(distance_between(expected, end), default_tolerance) << i;
        }
        EXPECT_GT(hits, 8);
    }
}
INSTANTIATE_TEST_SUITE_P(Strategies, FallingCamera, testing::Values("scalar", "packet"));

// No light comes from where a ray inside the horizon approaches it without reaching it, because p_t or P(r₊) has the
// wrong sign, or turns back outside.
TEST(FallingCamera, RaysThatCannotEscapeAreCaptured) {
    for (const double spin : {0.0, 0.5, 0.9, 0.99})
        for (const double depth : {0.97, 0.7})
            for (const std::string& objects : {std::string(), walls(6)}) {
                const double r = depth * (1 + std::sqrt(1 - spin * spin));
                SCOPED_TRACE(testing::Message() << "spin " << spin << ", r = " << r << ' ' << objects);
                const auto plan = plan_for_rays(scene_with_hole(spin, objects), "falling");
                std::vector<RayInput> rays;
                for (const Double3& d : even_directions(500)) rays.push_back({position_at(spin, r, 1.2, 0.7), d});
                const auto starts = start_rays(*plan, rays, ObserverKind::falling);
                const auto ends = traced(*plan, starts);
                for (std::size_t i = 0; i < ends.size(); ++i) {
                    const KerrGeodesic ray = geodesic_of(*plan, starts[i]);
                    if (is_critical(ray)) continue;
                    const Status outside = objects.empty() ? Status::escaped : Status::hit;
                    EXPECT_EQ(ends[i].status, ray.escape_margin() > 0 ? outside : Status::captured) << "ray " << i;
                }
            }
}

/// A falling camera deep inside a hole without spin, which looks sideways.
constexpr const char* deep_scene =
    "space = { hamiltonian = \"schwarzschild\", rg = 1 }\n[integrator]\nescape_radius = 100\n[camera]\n"
    "position = [-0.01, 0, 0]\nlook_at = [-0.01, 1, 0]\nup = [0, 0, 1]\nfov = 30\nobserver = \"falling\"\n"
    "[film]\nsize = [160, 120]\n";

// At r = 0.01 r_g, the sky ends 95.7° from the outward direction: E = 1 + √(r_g/r) cos α is 0 there. The swept angle is
// φ = ∫ L du/√(E² − (1 − r_g u) L² u²) with L = r sin α.
TEST(FallingCamera, SeesTheEdgeOfTheSkyDeepInsideInTheRightDirection) {
    for (const char* strategy : {"scalar", "packet"}) {
        const auto plan = plan_for_rays(deep_scene, "falling", strategy);
        for (const double degrees : {60.0, 90.0, 95.0, 95.5}) {
            const double alpha = degrees * std::numbers::pi / 180, r = 0.01;
            const RayInput ray{{-r, 0, 0}, {-std::cos(alpha), std::sin(alpha), 0}};
            const RayEnd end = traced(*plan, start_rays(*plan, {ray}, ObserverKind::falling))[0];
            ASSERT_EQ(end.status, Status::escaped) << degrees;
            const double E = 1 + std::cos(alpha) / std::sqrt(r), L = r * std::sin(alpha);
            const auto radial_speed = [&](double u) { return std::sqrt(E * E - (1 - u) * L * L * u * u); };
            boost::math::quadrature::tanh_sinh<double> quadrature;
            // The azimuth decreases from π, because the ray starts on the negative x axis towards +y.
            const double swept = quadrature.integrate([&](double u) { return L / radial_speed(u); }, 0.01, 1 / r);
            const double azimuth = std::numbers::pi - swept, turn = std::atan2(0.01 * L, radial_speed(0.01));
            const double v[2] = {std::cos(azimuth - turn), std::sin(azimuth - turn)};
            EXPECT_NEAR(end.q[0] / 100, std::cos(azimuth), 1e-9) << strategy << ' ' << degrees;
            EXPECT_NEAR(end.q[1] / 100, std::sin(azimuth), 1e-9) << strategy << ' ' << degrees;
            EXPECT_NEAR(end.v[0], v[0], 1e-9) << strategy << ' ' << degrees;
            EXPECT_NEAR(end.v[1], v[1], 1e-9) << strategy << ' ' << degrees;
        }
    }
}

/// Returns the ends of a falling camera's rays in even directions.
std::vector<RayEnd> view_at(double spin, const Double3& position, const char* strategy) {
    const auto plan = plan_for_rays(scene_with_hole(spin), "falling", strategy);
    std::vector<RayInput> rays;
    for (const Double3& d : even_directions(400)) rays.push_back({position, d});
    return traced(*plan, start_rays(*plan, rays, ObserverKind::falling));
}

// The view changes smoothly while the camera crosses the horizon: the second difference of the end directions at the
// radii r₊(1 − ε), r₊(1 + ε) and r₊(1 + 3ε) is of order ε². Near the edge of the shadow, directions go with the
// logarithm f of the distance from the edge. There, f'' = f'², so that the second difference is the square of the first
// one.
// Positions on the axis of a Kerr hole, and all positions near a Schwarzschild hole, are the same in both charts.
TEST_P(FallingCamera, ViewHasNoJumpAtTheHorizon) {
    constexpr double epsilon = 1e-4;
    for (const double spin : {0.9, 0.0}) {
        const double horizon = 1 + std::sqrt(1 - spin * spin);
        std::vector<RayEnd> ends[3];
        for (const int i : {0, 1, 2}) {
            const double r = horizon * (1 + (2 * i - 1) * epsilon);
            ends[i] = view_at(spin, spin == 0 ? position_at(0, r, 1.1, 0.6) : Double3{0, 0, r}, GetParam());
        }
        std::size_t compared = 0;
        for (std::size_t i = 0; i < ends[0].size(); ++i) {
            const RayEnd &inside = ends[0][i], &outside = ends[1][i], &farther = ends[2][i];
            EXPECT_EQ(inside.status, outside.status) << spin << ' ' << i;
            EXPECT_EQ(outside.status, farther.status) << spin << ' ' << i;
            if (inside.status != Status::escaped || farther.status != Status::escaped) continue;
            ++compared;
            double first = 0, second = 0;
            for (int k = 0; k < 3; ++k) {
                first = std::max(first, std::abs(outside.v[k] - farther.v[k]));
                second = std::max(second, std::abs(inside.v[k] - 2 * outside.v[k] + farther.v[k]));
            }
            EXPECT_LT(second, 3 * first * first + 30 * epsilon * epsilon) << spin << ' ' << i;
        }
        EXPECT_GT(compared, 300u);
    }
}

}  // namespace
}  // namespace kagero::test

// Compares rays around a Schwarzschild black hole with closed forms, mainly elliptic integrals. The tests cover the
// swept angle, capture and escape, the conserved quantities, and the shadow that a static observer sees.
#include "tests/support/greatest.h"
#include "tests/support/plan_fixture.h"
#include "tests/support/schwarzschild_orbit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace kagero::test {
namespace {

constexpr double start_radius = 20;

/// Returns nine orbit planes: two along coordinate axes and seven random ones, from a fixed seed.
std::vector<OrbitPlane> orbit_planes() {
    std::vector<OrbitPlane> all{{{1, 0, 0}, {0, 1, 0}}, {{0, 0, -1}, {0, 1, 0}}};
    std::mt19937 random(16);
    std::normal_distribution<double> normal;
    const auto unit = [](Double3 a) {
        const double size = std::hypot(a[0], a[1], a[2]);
        for (double& x : a) x /= size;
        return a;
    };
    while (all.size() < 9) {
        const Double3 n = unit({normal(random), normal(random), normal(random)});
        const Double3 w{normal(random), normal(random), normal(random)};
        all.push_back({n, unit({n[1] * w[2] - n[2] * w[1], n[2] * w[0] - n[0] * w[2], n[0] * w[1] - n[1] * w[0]})});
    }
    return all;
}

/// Rays with their orbit planes and impact parameters.
struct RayBundle {
    std::vector<OrbitPlane> planes;
    std::vector<double> impact;
    std::vector<RayInput> rays;
};

/// Returns one ray for each impact parameter in each orbit plane. All start at r = 20 r_g and move inward.
RayBundle rays_inward(const std::vector<double>& impacts, const Double3& center = {0, 0, 0}) {
    RayBundle bundle;
    for (const OrbitPlane& plane : orbit_planes())
        for (const double b : impacts) {
            bundle.planes.push_back(plane);
            bundle.impact.push_back(b);
            bundle.rays.push_back(ray_inward(plane, b, start_radius, center));
        }
    return bundle;
}

std::vector<RayEnd> ends_of(const Plan& plan, const std::vector<RayInput>& rays, const std::string& observer = "") {
    std::vector<RayEnd> ends;
    trace(plan, start_rays(plan, rays, observer_of(observer)), ends);
    return ends;
}

/// Returns the position relative to the centre of the space.
Double3 position_from_center(const Plan& plan, const double (&q)[3]) {
    const Double3& c = plan.description().space.center;
    return {q[0] - c[0], q[1] - c[1], q[2] - c[2]};
}

/// Returns the greatest error of the swept angles modulo 2π. The reference is an elliptic integral.
double greatest_angle_error(const Plan& plan, const RayBundle& bundle) {
    const auto ends = ends_of(plan, bundle.rays);
    double largest = 0;
    for (std::size_t i = 0; i < ends.size(); ++i) {
        EXPECT_EQ(ends[i].status, Status::escaped) << "b = " << bundle.impact[i];
        const double angle = bundle.planes[i].angle_of(position_from_center(plan, ends[i].q));
        const double expected = Orbit(bundle.impact[i]).swept_around(start_radius);
        largest = greatest(largest, std::abs(std::remainder(angle - expected, 2 * std::numbers::pi)));
    }
    return largest;
}

std::string center_setting(const Double3& c) {
    return "space.center=[" + std::to_string(c[0]) + "," + std::to_string(c[1]) + "," + std::to_string(c[2]) + "]";
}

TEST(EllipticIntegrals, MatchNumericalQuadrature) {
    for (const double b : {2.7, 3.0, 5.0, 10.0}) {
        const Orbit orbit(b);
        // Both values are exact to rounding. The square root at the turning point amplifies rounding errors to a few
        // hundred ulp.
        EXPECT_NEAR(orbit.swept_around(20), swept_around_by_quadrature(orbit, 20), 1e-13) << b;
        const double r = 1.2 / orbit.ub;
        EXPECT_NEAR(orbit.swept(20, r), swept_by_quadrature(b, 20, r), 1e-13) << b;
        EXPECT_NEAR(orbit.radius_after(20, orbit.swept(20, r)), r, 1e-13 * r) << b;
    }
}

class Deflection : public testing::TestWithParam<std::tuple<const char*, const char*>> {
protected:
    static std::unique_ptr<Plan> plan(const std::string& method, double step, const Double3& center = {0, 0, 0}) {
        const auto [strategy, rescale] = GetParam();
        return plan_of_file(scene_file("hole.toml"),
                            {"integrator.escape_radius=20", "integrator.method=" + method,
                             "integrator.step=" + std::to_string(step), std::string("integrator.rescale=") + rescale,
                             center_setting(center)},
                            with_strategy(strategy), false);
    }
    /// Returns a step size that resolves the bending near the hole. The step is in λ without time rescaling, otherwise
    /// in τ, where dλ = r dτ.
    static double fine_step() { return std::string(std::get<1>(GetParam())) == "none" ? 0.2 : 0.1; }
};

// The error of one step of order 12 is about 1e-12. The tolerance allows for the sum over the steps near the hole.
TEST_P(Deflection, SweptAngleMatchesTheEllipticIntegral) {
    for (const Double3& center : {Double3{0, 0, 0}, Double3{0.5, -3, 7}, Double3{100, -20, 30}}) {
        const auto p = plan("gauss12", fine_step(), center);
        EXPECT_LT(greatest_angle_error(*p, rays_inward({3, 5, 10}, center)), 1e-9) << center_setting(center);
    }
}

// With a quarter of the step size, the error of a method of order p must decrease by 4^p, with a tolerance of half an
// order. The rounding error is about 1e-11: some thousand roundings of a state of size 20. The error with the coarse
// step h must be at most 100 h^p, where p is the order but at most 4.
TEST_P(Deflection, AllMethodsConvergeToTheEllipticIntegral) {
    // b = 3 is left out, because the error of some methods changes sign near this step size.
    const RayBundle rays = rays_inward({5, 10});
    const auto example = plan("gauss4", 1);
    for (std::uint32_t i = 0; i < example->module().integrator_count; ++i) {
        const IntegratorInfo& method = example->module().integrators[i];
        if (method.adaptive || refusal_of(*example->scene, i, example->run.method.rescaled)) continue;
        const double step = fine_step() * (method.order <= 2 ? 0.25 : 1.0), floor = 1e-11;
        const double coarse = greatest_angle_error(*plan(method.name, step), rays),
                     fine = greatest_angle_error(*plan(method.name, step / 4), rays);
        SCOPED_TRACE(method.name);
        EXPECT_LT(fine, coarse * std::pow(4, 0.5 - method.order) + floor) << coarse;
        EXPECT_LT(coarse, std::min(1.0, std::pow(step, std::min(method.order, 4u)) * 100));
    }
}

TEST_P(Deflection, CaptureAndEscapeAreCorrectNearTheCriticalImpactParameter) {
    const auto p = plan("gauss12", fine_step());
    for (const double distance : {1e-2, 1e-4, 1e-6}) {
        const RayBundle inside = rays_inward({critical_impact * (1 - distance)}),
                        outside = rays_inward({critical_impact * (1 + distance)});
        for (const RayEnd& end : ends_of(*p, inside.rays)) {
            EXPECT_EQ(end.status, Status::captured) << "b/b_c = 1 - " << distance;
            const Double3 q = position_from_center(*p, end.q);
            EXPECT_NEAR(std::hypot(q[0], q[1], q[2]), 1, 1.0001e-3);  // within 0.001 of the horizon
        }
        // The derivative of the angle with respect to b is about 1/(b − b_c). A relative rounding error of 1e-13 in b
        // therefore changes the angle by about 1e-13/distance.
        EXPECT_LT(greatest_angle_error(*p, outside), 1e-9 + 1e-13 / distance) << "b/b_c = 1 + " << distance;
    }
}

TEST_P(Deflection, AngularMomentumAndPtAreConserved) {
    const RayBundle rays = rays_inward({critical_impact * (1 + 1e-4), 3, 10});
    const auto cross = [](const Double3& a, const double(&b)[3]) {
        return Double3{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    };
    // Symplectic methods preserve the angular momentum q × p to rounding, because it is bilinear. The bound is the sum
    // of one rounding of |q||p| = 20 in each of up to 3600 stages.
    const double rounding = 3600 * start_radius * std::numeric_limits<double>::epsilon();
    for (const char* method : {"verlet", "suzuki4-nine", "gauss4", "gauss12"}) {
        const auto p = plan(method, fine_step());
        const auto starts = start_rays(*p, rays.rays);
        std::vector<RayEnd> ends;
        trace(*p, starts, ends);
        for (std::size_t i = 0; i < ends.size(); ++i) {
            const Double3 before = cross({starts[i].q[0], starts[i].q[1], starts[i].q[2]}, starts[i].p);
            const Double3 after = cross(position_from_center(*p, ends[i].q), ends[i].p);
            for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(after[k], before[k], rounding) << method;
            EXPECT_NEAR(std::hypot(before[0], before[1], before[2]), rays.impact[i], 1e-13 * rays.impact[i]);
            EXPECT_EQ(starts[i].pt, 1.0);
            EXPECT_EQ(ends[i].pt, 1.0) << method;
        }
    }
}

// The angle along the path is not reduced modulo 2π, so that the number of turns is compared as well.
TEST_P(Deflection, SweptAngleOfPathsMatchesTheEllipticIntegral) {
    const double b = critical_impact * (1 + 1e-6);
    const auto p = plan("gauss12", fine_step());
    const RayBundle rays = rays_inward({b});
    std::vector<RayEnd> ends;
    const auto points = trace_paths(*p, start_rays(*p, rays.rays), ends);
    std::vector<double> swept(rays.rays.size(), 0), last(rays.rays.size(), 0);
    for (const PathPoint& point : points) {
        const double angle = rays.planes[point.ray].angle_of(position_from_center(*p, point.q));
        swept[point.ray] += std::remainder(angle - last[point.ray], 2 * std::numbers::pi);
        last[point.ray] = angle;
    }
    const double expected = Orbit(b).swept_around(start_radius);
    EXPECT_GT(expected, 2 * 2 * std::numbers::pi);
    // The tolerance is a relative rounding error of 1e-13 in b, divided by b/b_c − 1 = 1e-6.
    for (const double angle : swept) EXPECT_NEAR(angle, expected, 1e-7);
}

INSTANTIATE_TEST_SUITE_P(Strategies, Deflection,
                         testing::Combine(testing::Values("scalar", "packet"), testing::Values("auto", "none")),
                         [](const auto& chosen) {
                             return std::string(std::get<0>(chosen.param)) + "_rescale_" + std::get<1>(chosen.param);
                         });

/// Returns the angular radius of the shadow for a static observer at radius r, in degrees. It is the angle, measured
/// from the direction to the centre, that separates captured from escaped rays. Each round divides the interval that
/// contains the angle by 64, until the interval is shorter than 1e-8.
double shadow_edge(const Plan& plan, double r) {
    double inside = 0, outside = 90;
    while (outside - inside > 1e-8) {
        std::vector<RayInput> rays;
        for (int i = 0; i <= 64; ++i) {
            const double angle = (inside + (outside - inside) * i / 64) * std::numbers::pi / 180;
            rays.push_back({{0, -r, 0}, {std::sin(angle) * 0.6, std::cos(angle), std::sin(angle) * 0.8}});
        }
        const auto ends = ends_of(plan, rays, "static");
        int captured_count = 0;
        for (const RayEnd& end : ends) {
            if (end.status != Status::captured) break;
            ++captured_count;
        }
        EXPECT_GT(captured_count, 0);
        EXPECT_LE(captured_count, 64);
        for (int i = captured_count; i <= 64; ++i) EXPECT_EQ(ends[static_cast<std::size_t>(i)].status, Status::escaped);
        const double width = (outside - inside) / 64;
        outside = inside + captured_count * width;
        inside = outside - width;
        if (testing::Test::HasFailure()) break;
    }
    return 0.5 * (inside + outside);
}

// The angular radius θ of the shadow obeys sin θ = b_c √(1 − r_g/r) / r (Synge 1966), so that θ = 45° at r = 3 r_g.
TEST(StaticObserver, ShadowMatchesSynge) {
    const auto plan = plan_of_file(scene_file("hole.toml"),
                                   {"integrator.escape_radius=20", "integrator.method=gauss12", "integrator.step=0.1"},
                                   with_strategy("packet"), false);
    for (const double r : {3.0, 10.0, 15.0}) {
        const double expected = std::asin(critical_impact * std::sqrt(1 - 1 / r) / r) * 180 / std::numbers::pi;
        EXPECT_NEAR(shadow_edge(*plan, r), expected, 1e-6) << "r = " << r;
    }
    EXPECT_NEAR(shadow_edge(*plan, 3), 45, 1e-6);
}

// The ray of a pixel must be equal to a listed ray with the same position and direction.
TEST(StaticObserver, CameraRaysMatchListedRays) {
    const auto plan =
        plan_of_file(scene_file("hole.toml"), {"integrator.escape_radius=20", "film.size=[8, 8]", "camera.fov=40"},
                     with_strategy("packet"));
    const double pixel = 2 * std::tan(20 * std::numbers::pi / 180) / 8;
    const RayStart by_camera = pixel_ray_start(*plan, 1, 6);  // 2½ pixels left of and below the centre
    const RayStart listed =
        start_rays(*plan, {{{0, -10, 0}, {-2.5 * pixel, 1, -2.5 * pixel}}}, ObserverKind::static_)[0];
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(by_camera.p[k], listed.p[k], 1e-15);
    EXPECT_EQ(by_camera.pt, listed.pt);
}

}  // namespace
}  // namespace kagero::test

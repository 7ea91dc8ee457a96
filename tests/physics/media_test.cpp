// Compares rays in media with closed forms: circles, parabolas, harmonic oscillations, Snell's law, and a focus.
#include "tests/support/plan_fixture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace kagero::test {
namespace {

/// Returns a scene with one medium. Its camera is not used.
std::string medium(const std::string& space, const std::string& integrator) {
    return "[space]\n" + space + "\n[integrator]\nmethod = \"gauss8\"\nmax_steps = 1000000\n" + integrator +
           "\n[camera]\nposition = [0, 0, 0]\nlook_at = [1, 0, 0]\nup = [0, 0, 1]\n[film]\nsize = [4, 4]\n";
}

class Media : public testing::TestWithParam<const char*> {
protected:
    static std::vector<RayEnd> trace_all(const std::string& scene, const std::vector<RayInput>& rays,
                                         double parameter_limit = std::numeric_limits<double>::infinity()) {
        const auto plan = plan_of_text(scene, {}, with_strategy(GetParam()), false);
        plan->run.parameter_limit = parameter_limit;
        std::vector<RayEnd> ends;
        trace(*plan, start_rays(*plan, rays), ends);
        return ends;
    }
};

constexpr double tolerance = 1e-9;

// With symmetry = "auto", coordinates on which H does not depend are updated once per step, not in every substep. The
// ends must be equal, up to rounding, to those with symmetry = "none".
TEST_P(Media, SymmetryOfStratifiedMediaDoesNotChangeRays) {
    const char* const spaces[] = {"hamiltonian = \"gradient\"\nn0 = 1.5\ng = 0.3", "hamiltonian = \"layer\"",
                                  "hamiltonian = \"duct\"", "hamiltonian = \"mirage\""};
    for (const char* space : spaces) {
        SCOPED_TRACE(space);
        std::vector<RayInput> rays;
        for (int i = 0; i < 20; ++i)
            rays.push_back({{0, 0, 0.1}, {std::cos(i * 0.7), std::sin(i * 0.7), 0.3 * std::cos(i * 1.9)}});
        std::vector<RayEnd> ends[2];
        std::uint64_t different = 0;
        for (const bool symmetry : {false, true}) {
            const std::string integrator =
                std::string("step = 0.05\nescape_radius = 4\nsymmetry = \"") + (symmetry ? "auto" : "none") + "\"";
            const auto plan =
                plan_of_text(medium(space, integrator), {"integrator.method=srkn6"}, with_strategy(GetParam()), false);
            trace(*plan, start_rays(*plan, rays), ends[symmetry]);
        }
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const RayEnd &a = ends[0][i], &b = ends[1][i];
            ASSERT_EQ(a.status, b.status);
            for (int k = 0; k < 3; ++k) {
                EXPECT_NEAR(a.q[k], b.q[k], 1e-12);
                EXPECT_NEAR(a.p[k], b.p[k], 1e-12);
                different += a.q[k] != b.q[k];
            }
        }
        EXPECT_GT(different, 0u) << "Some ends must differ by rounding, or the symmetry was not used.";
    }
}

// A constant factor of the index of refraction must change neither the rays nor the number of steps, if the step has
// its default.
TEST_P(Media, RaysDoNotDependOnAFactorOfTheIndex) {
    const std::vector<RayInput> rays{{{-0.7, 0.2, 0.1}, {0.3, 0.85, 0.19}}, {{0.3, -0.1, 0.4}, {-0.5, 0.2, 0.4}}};
    for (const char* space : {"hamiltonian = \"fiber\"", "hamiltonian = \"fisheye\"", "hamiltonian = \"shimmer\""}) {
        std::vector<RayEnd> ends[3];
        const char* const indices[] = {"1.5", "1e-4", "1e4"};
        for (std::size_t i = 0; i < 3; ++i)
            ends[i] = trace_all(medium(std::string(space) + "\nn0 = " + indices[i], "escape_radius = 1.2"), rays);
        for (const std::size_t i : {1u, 2u})
            for (std::size_t ray = 0; ray < rays.size(); ++ray) {
                SCOPED_TRACE(testing::Message() << space << ", n0 = " << indices[i] << ", ray " << ray);
                ASSERT_EQ(ends[i][ray].status, ends[0][ray].status);
                EXPECT_EQ(ends[i][ray].steps, ends[0][ray].steps);
                for (int k = 0; k < 3; ++k) EXPECT_NEAR(ends[i][ray].q[k], ends[0][ray].q[k], tolerance);
            }
    }
}

/// The circle of a ray in Maxwell's fisheye of radius 1 (Born & Wolf, §4.2.2). It passes through q in direction d, and
/// lies in the plane spanned by q and d. The power of the origin with respect to the circle is −1.
struct FisheyeCircle {
    Double3 centre;
    double radius;
    FisheyeCircle(const double (&q)[3], const double (&d)[3]) {
        const double dd = d[0] * d[0] + d[1] * d[1] + d[2] * d[2], qd = q[0] * d[0] + q[1] * d[1] + q[2] * d[2];
        double n[3], nn = 0, qn = 0, qq = 0;  // n: component of q normal to d
        for (int k = 0; k < 3; ++k) {
            n[k] = q[k] - qd / dd * d[k];
            nn += n[k] * n[k];
            qn += q[k] * n[k];
            qq += q[k] * q[k];
        }
        const double s = -(qq + 1) / (2 * qn);
        for (int k = 0; k < 3; ++k) centre[static_cast<std::size_t>(k)] = q[k] + s * n[k];
        radius = std::abs(s) * std::sqrt(nn);
    }
    /// Returns the relative distance of x from the circle, for x in the plane of the circle.
    double error(const double* x) const {
        return std::hypot(x[0] - centre[0], x[1] - centre[1], x[2] - centre[2]) / radius - 1;
    }
};

// All rays from q are circles through the image −q/|q|² of q.
TEST_P(Media, FisheyeRaysAreCirclesThroughTheImage) {
    const double q[3] = {0.3, -0.4, 0.2}, square = 0.29, image[3] = {-q[0] / square, -q[1] / square, -q[2] / square};
    const std::string scene =
        medium("hamiltonian = \"fisheye\"\nn0 = 2\nradius = 1", "step = 0.02\nescape_radius = 100");
    const auto plan = plan_of_text(scene, {}, with_strategy(GetParam()), false);
    plan->run.parameter_limit = 3;
    std::vector<RayInput> rays;
    for (int i = 0; i < 20; ++i)
        rays.push_back({{q[0], q[1], q[2]}, {std::cos(i * 0.7), std::sin(i * 0.7), std::cos(i * 1.9)}});
    const auto starts = start_rays(*plan, rays);
    std::vector<RayEnd> ends;
    for (const PathPoint& point : trace_paths(*plan, starts, ends)) {
        const FisheyeCircle circle(starts[point.ray].q, starts[point.ray].p);
        EXPECT_NEAR(circle.error(point.q), 0, tolerance) << "ray " << point.ray << ", step " << point.step;
    }
    // N is the index of refraction. Up to λ = 30, rays on circles within the distance 2.5 from the centre complete a
    // full circle.
    plan->run.parameter_limit = 30;
    std::vector<double> nearest(rays.size(), 1e300);
    for (const PathPoint& point : trace_paths(*plan, starts, ends)) {
        const double distance = std::hypot(point.q[0] - image[0], point.q[1] - image[1], point.q[2] - image[2]);
        nearest[point.ray] = std::min(nearest[point.ray], distance);
    }
    std::size_t full_circles = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const FisheyeCircle circle(starts[i].q, starts[i].p);
        if (std::hypot(circle.centre[0], circle.centre[1], circle.centre[2]) + circle.radius > 2.5) continue;
        ++full_circles;
        EXPECT_LT(nearest[i], 0.02) << i;  // near the image, N = 0.45 and a step has the length 0.02 N
    }
    EXPECT_GE(full_circles, 5u);
}

// The closed form is z = z0 + p_z τ − g τ²/4, x = x0 + p_x τ.
TEST_P(Media, RaysInGradientAreParabolas) {
    const double g = 0.1, tau = 3.5;
    const std::string scene = medium("hamiltonian = \"gradient\"\nn0 = 1\ng = 0.1", "step = 0.1\nescape_radius = 1000");
    const auto plan = plan_of_text(scene, {}, with_strategy(GetParam()), false);
    const std::vector<RayInput> rays{{{0, 0, 0}, {1, 0, 0.5}}, {{0.5, 1, -1}, {0.2, 1, 1}}, {{0, 0, 2}, {1, 1, -1}}};
    const auto starts = start_rays(*plan, rays);
    const auto ends = trace_all(scene, rays, tau);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const RayStart& s = starts[i];
        EXPECT_EQ(ends[i].parameter, tau);
        EXPECT_NEAR(ends[i].q[0], s.q[0] + s.p[0] * tau, tolerance);
        EXPECT_NEAR(ends[i].q[1], s.q[1] + s.p[1] * tau, tolerance);
        EXPECT_NEAR(ends[i].q[2], s.q[2] + s.p[2] * tau - g * tau * tau / 4, tolerance);
    }
}

// x and y are harmonic with the angular frequency n0 α.
TEST_P(Media, RaysInFiberAreHarmonic) {
    const double omega = 1.5 * 0.3, period = 2 * std::numbers::pi / omega;
    const std::string scene =
        medium("hamiltonian = \"fiber\"\nn0 = 1.5\nalpha = 0.3", "step = 0.05\nescape_radius = 1000");
    const std::vector<RayInput> rays{{{0.5, 0, 0}, {0.1, 0, 1}}, {{0, 1, 0}, {0.4, 0.2, 1}}, {{-1, 1, 0}, {0, 0, 1}}};
    const auto full = trace_all(scene, rays, period), quarter = trace_all(scene, rays, period / 4);
    const auto plan = plan_of_text(scene, {}, with_strategy(GetParam()), false);
    const auto starts = start_rays(*plan, rays);
    for (std::size_t i = 0; i < rays.size(); ++i)
        for (int k = 0; k < 2; ++k) {
            EXPECT_NEAR(full[i].q[k], starts[i].q[k], tolerance);
            EXPECT_NEAR(quarter[i].q[k], starts[i].p[k] / omega, tolerance);
            EXPECT_NEAR(quarter[i].p[k], -starts[i].q[k] * omega, tolerance);
        }
}

// Snell's law: n sin θ is equal on both sides of the layer. Beyond the critical angle all light is reflected.
TEST_P(Media, LayerObeysSnellsLaw) {
    const std::string scene = medium("hamiltonian = \"layer\"\nn_below = 1.5\nn_above = 1.0\nthickness = 0.1",
                                     "step = 0.01\nescape_radius = 60");
    const double critical = std::asin(1 / 1.5);
    std::vector<double> angles;
    std::vector<RayInput> rays;
    for (const double fraction : {0.0, 0.3, 0.7, 0.95, 1.05, 1.3, 1.6}) {
        angles.push_back(fraction * critical);
        rays.push_back({{0, 0, -2}, {std::sin(angles.back()), 0, std::cos(angles.back())}});
    }
    const auto ends = trace_all(scene, rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        ASSERT_EQ(ends[i].status, Status::escaped);
        const bool transmitted = angles[i] < critical;
        EXPECT_EQ(ends[i].q[2] > 0, transmitted) << angles[i];
        EXPECT_NEAR(ends[i].v[0], transmitted ? 1.5 * std::sin(angles[i]) : std::sin(angles[i]), tolerance);
        EXPECT_NEAR(ends[i].v[2], (transmitted ? 1 : -1) * std::sqrt(1 - ends[i].v[0] * ends[i].v[0]), tolerance);
    }
}

// Parallel rays meet in one point: the point of the surface that is farthest from their start.
TEST_P(Media, LuneburgFocusesParallelRays) {
    for (const double step : {0.25, 0.1}) {
        const std::string scene =
            medium("hamiltonian = \"luneburg\"\nradius = 2", "step = " + std::to_string(step) + "\nescape_radius = 2");
        std::vector<RayInput> rays;
        for (int i = 0; i < 17; ++i) rays.push_back({{-5, -1.95 + 3.9 * i / 16, 0.1}, {1, 0, 0}});
        for (const RayEnd& end : trace_all(scene, rays)) {
            ASSERT_EQ(end.status, Status::escaped);
            EXPECT_NEAR(end.q[0], 2, 1e-8);
            EXPECT_NEAR(end.q[1], 0, 1e-8);
            EXPECT_NEAR(end.q[2], 0, 1e-8);
        }
    }
}

// A grazing ray enters and leaves the ball within few steps. Inside the ball, q'' = −q/R². A ray along x that enters at
// q₀ leaves with the y and z components of the direction −q₀/R.
TEST_P(Media, LuneburgDeflectsGrazingRays) {
    const std::string scene = medium("hamiltonian = \"luneburg\"\nradius = 1", "step = 0.25\nescape_radius = 12");
    std::vector<RayInput> rays;
    for (int i = 0; i < 300; ++i) {
        // For b > 0.992 a step is longer than the straight path through the ball.
        const double b = 1 - std::pow(0.1, 1 + 0.018 * i);
        rays.push_back({{-5 - 0.001 * (i * 37 % 250), b * std::cos(1.0 * i), b * std::sin(1.0 * i)}, {1, 0, 0}});
    }
    const auto ends = trace_all(scene, rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        ASSERT_EQ(ends[i].status, Status::escaped) << i;
        const auto& q = rays[i].position;
        EXPECT_NEAR(ends[i].v[0], std::sqrt(1 - q[1] * q[1] - q[2] * q[2]), 1e-6) << i;
        EXPECT_NEAR(ends[i].v[1], -q[1], 1e-6) << i;
        EXPECT_NEAR(ends[i].v[2], -q[2], 1e-6) << i;
    }
}

// Outside the ball rays are straight, and one step can cover a whole straight segment, also if the segment ends at a
// surface. The bounds on the numbers of steps allow for the steps inside the ball and for the escape. Inside the ball,
// q = q₀ cos τ + p₀ sin τ. A ray along x that enters at q₀ leaves at (1, 0, 0), with −q₀ as the transverse
// direction.
TEST_P(Media, RaysOutsideLuneburgAreStraightAndTakeFewSteps) {
    const std::string scene =
        medium("hamiltonian = \"luneburg\"\nradius = 1", "step = 0.25\nescape_radius = 1000") +
        "[[object]]\nshape = \"rectangle\"\norigin = [300, -400, -400]\nedge_u = [0, 800, 0]\nedge_v = [0, 0, 800]\n"
        "[[object]]\nshape = \"sphere\"\ncenter = [200, -50, 0]\nradius = 2\n";
    std::vector<RayInput> rays;
    for (const double b : {0.0, 0.4, 0.6, 1.0 + 1e-9, 1.5, 20.0}) rays.push_back({{-700, 0.8 * b, 0.6 * b}, {1, 0, 0}});
    rays.push_back({{100, -50, 0}, {1, 0, 0}});
    rays.push_back({{-3, 4, 0}, {-0.6, 0.8, 0}});
    const auto ends = trace_all(scene, rays);
    for (std::size_t i = 0; i < 6; ++i) {
        SCOPED_TRACE(i);
        const double y = rays[i].position[1], z = rays[i].position[2], x = std::sqrt(std::max(1 - y * y - z * z, 0.0));
        const bool enters_ball = x > 0;
        ASSERT_EQ(ends[i].status, Status::hit);
        EXPECT_EQ(ends[i].surface, 0u);
        EXPECT_NEAR(ends[i].q[0], 300, 1e-9);
        EXPECT_NEAR(ends[i].q[1], enters_ball ? -y * 299 / x : y, 1e-7 / std::max(x, 0.01));
        EXPECT_NEAR(ends[i].q[2], enters_ball ? -z * 299 / x : z, 1e-7 / std::max(x, 0.01));
        EXPECT_LE(ends[i].steps, enters_ball ? 16u : 1u);
    }
    EXPECT_EQ(ends[6].surface, 1u);
    EXPECT_NEAR(ends[6].q[0], 198, 1e-9);
    EXPECT_EQ(ends[7].status, Status::escaped);
    EXPECT_NEAR(ends[7].q[0], -600, 1e-9);
    EXPECT_LE(ends[7].steps, 2u);
}

// Equal seeds result in equal rays, different seeds in different rays. With the amplitude 0 rays are straight.
TEST_P(Media, EqualSeedsGiveEqualShimmer) {
    const auto scene = [](const char* key) {
        return medium(std::string("hamiltonian = \"shimmer\"\n") + key, "step = 0.1\nescape_radius = 20");
    };
    const std::vector<RayInput> rays{{{0, 0, 0}, {1, 0.2, 0.1}}};
    const auto first = trace_all(scene("seed = 1"), rays), repeated = trace_all(scene("seed = 1"), rays),
               second = trace_all(scene("seed = 2"), rays);
    const auto straight = trace_all(scene("amplitude = 0"), rays);
    EXPECT_EQ(first[0].q[1], repeated[0].q[1]);
    EXPECT_GT(std::abs(first[0].q[1] - second[0].q[1]), 1e-3);
    EXPECT_NEAR(straight[0].v[1] / straight[0].v[0], 0.2, tolerance);
}

INSTANTIATE_TEST_SUITE_P(Strategies, Media, testing::Values("scalar", "packet"),
                         [](const auto& chosen) { return std::string(chosen.param); });

// The limit 0.1 is not representable in float. The reported λ must nevertheless be exactly 0.1.
TEST(MediaInFloat, RaysEndExactlyAtTheLimitOfTheParameter) {
    Options options = with_strategy("packet");
    options.precision = Precision::float32;
    const auto plan = plan_of_text(medium("hamiltonian = \"fisheye\"", "escape_radius = 100"), {}, options, false);
    plan->run.parameter_limit = 0.1;
    std::vector<RayEnd> ends;
    trace(*plan, start_rays(*plan, {{{0.3, -0.4, 0.2}, {1, 0, 0}}}), ends);
    EXPECT_EQ(ends[0].status, Status::step_limit);
    EXPECT_EQ(ends[0].parameter, 0.1);
}

}  // namespace
}  // namespace kagero::test

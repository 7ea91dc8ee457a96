// Tests ray ends inside long steps. The ends are compared with closed forms and with rays of short steps.
#include "tests/support/plan_fixture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace kagero::test {
namespace {

std::string scene_of(const std::string& space, const std::string& integrator, const std::string& objects = "") {
    return "[space]\n" + space + "\n[integrator]\n" + integrator +
           "\n[camera]\nposition = [0, 0, 0]\nlook_at = [1, 0, 0]\nup = [0, 0, 1]\n[film]\nsize = [4, 4]\n" + objects;
}

/// Returns n rays from one position in different directions.
std::vector<RayInput> rays_from(const Double3& position, int n) {
    std::vector<RayInput> rays;
    for (int i = 0; i < n; ++i) rays.push_back({position, {std::cos(i * 0.7), std::sin(i * 0.7), std::cos(i * 1.9)}});
    return rays;
}

class LongSteps : public testing::TestWithParam<const char*> {
protected:
    std::unique_ptr<Plan> plan_of(const std::string& scene, const Overrides& overrides = {}) const {
        return plan_of_text(scene, overrides, with_strategy(GetParam()), false);
    }
};

/// The path of a ray in the medium N² = n0² − g z: q0 + p τ − ẑ g τ²/4.
struct Parabola {
    RayStart start;
    double g;
    Double3 at(double t) const {
        return {start.q[0] + start.p[0] * t, start.q[1] + start.p[1] * t,
                start.q[2] + start.p[2] * t - 0.25 * g * t * t};
    }
    /// Returns the first zero of a function of position that is positive at the start, as a value of τ below `limit`.
    /// Returns infinity if there is none. The path is sampled at 20000 points, and the zero is found by bisection.
    double first_zero(const std::function<double(const Double3&)>& function, double limit) const {
        constexpr int samples = 20000;
        for (int i = 1; i <= samples; ++i) {
            double before = limit * (i - 1) / samples, after = limit * i / samples;
            if (function(at(after)) > 0) continue;
            for (int k = 0; k < 60; ++k) {
                const double middle = 0.5 * (before + after);
                (function(at(middle)) > 0 ? before : after) = middle;
            }
            return after;
        }
        return std::numeric_limits<double>::infinity();
    }
};

/// Returns the distance of a position from a sphere around the origin. The distance is negative outside the sphere.
double depth_in_sphere(const Double3& q, double radius) {
    return radius - std::hypot(q[0], q[1], q[2]);
}

// A parabola can leave the escape sphere and enter it again within one step. The ray must escape at the first crossing.
TEST_P(LongSteps, ParabolasEscapeAtTheFirstCrossingOfTheEscapeSphere) {
    for (const auto& [g, radius] : {std::pair{100.0, 0.02}, std::pair{0.3, 8.0}})
        for (const char* method : {"srkn6", "gauss8", "rk4", "dp54", "rkf78"}) {
            const std::string scene = scene_of("hamiltonian = \"gradient\"\nn0 = 1.5\ng = " + std::to_string(g),
                                               "tolerance = 1e-10\nescape_radius = " + std::to_string(radius));
            const auto plan = plan_of(scene, {std::string("integrator.method=") + method});
            const auto starts = start_rays(*plan, rays_from({0, -0.25 * radius, 0.015 * radius}, 60));
            std::vector<RayEnd> ends;
            trace(*plan, starts, ends);
            for (std::size_t i = 0; i < starts.size(); ++i) {
                SCOPED_TRACE(testing::Message() << method << ", g = " << g << ", ray " << i);
                ASSERT_EQ(ends[i].status, Status::escaped);
                const double unit = plan->scene->unit;  // the starts are in the unit of the kernels
                RayStart start = starts[i];
                for (double& x : start.q) x *= unit;
                const Parabola parabola{start, g};
                const double t = parabola.first_zero(
                    [&, radius = radius](const Double3& q) { return depth_in_sphere(q, radius); }, 50 * radius);
                const Double3 end = parabola.at(t);
                for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(ends[i].q[k], end[k], 1e-6 * radius);
                EXPECT_NEAR(ends[i].parameter, t, 1e-6 * radius);
            }
        }
}

// The floor extends beyond the escape sphere. Only rays that reach it before they leave the sphere must hit it.
TEST_P(LongSteps, ParabolasHitTheFloorOnlyInsideTheEscapeSphere) {
    constexpr double g = 0.3, radius = 5, floor = -1, half_width = 20;
    const std::string objects =
        "[[object]]\nname = \"floor\"\nshape = \"rectangle\"\norigin = [-20, -20, -1]\nedge_u = [40, 0, 0]\nedge_v = "
        "[0, 40, 0]\n";
    for (const char* method : {"srkn6", "gauss8", "dp54", "rkf78"}) {
        const auto plan = plan_of(scene_of("hamiltonian = \"gradient\"\nn0 = 1.5\ng = 0.3",
                                           "tolerance = 1e-12\nescape_radius = 5", objects),
                                  {std::string("integrator.method=") + method});
        const auto starts = start_rays(*plan, rays_from({0.5, -1, 0.7}, 300));
        std::vector<RayEnd> ends;
        trace(*plan, starts, ends);
        std::size_t hits = 0, escaped_above_floor = 0;
        for (std::size_t i = 0; i < starts.size(); ++i) {
            SCOPED_TRACE(testing::Message() << method << ", ray " << i);
            const Parabola parabola{starts[i], g};
            const double t_sphere =
                parabola.first_zero([&](const Double3& q) { return depth_in_sphere(q, radius); }, 400);
            const double t_floor = parabola.first_zero([&](const Double3& q) { return q[2] - floor; }, 400);
            const Double3 floor_point = parabola.at(t_floor);
            // Distance outside the edges of the floor; negative inside.
            const double outside = std::max(std::abs(floor_point[0]), std::abs(floor_point[1])) - half_width;
            // Rounding decides the status of rays that pass so close to an edge.
            if (std::abs(outside) < 1e-6 || std::abs(t_sphere - t_floor) < 1e-6) continue;
            const bool hit = outside < 0 && t_floor < t_sphere;
            ASSERT_EQ(ends[i].status, hit ? Status::hit : Status::escaped);
            const Double3 end = hit ? floor_point : parabola.at(t_sphere);
            for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(ends[i].q[k], end[k], 1e-7);
            hits += hit;
            escaped_above_floor += outside < 0 && !hit;
        }
        EXPECT_GT(hits, 20u) << method;
        EXPECT_GT(escaped_above_floor, 20u) << method;  // without the sphere, these rays would hit the floor
    }
}

// The lid is slightly below the highest points of the parabolas. A step may contain the highest point, so that the ray
// crosses the lid although both ends of the step and the chord are below it.
TEST_P(LongSteps, ParabolasHitALidBelowTheirHighestPoint) {
    const double g = 2, lid = 0.499;
    const std::string object =
        "[[object]]\nname = \"lid\"\nshape = \"rectangle\"\norigin = [-3, -3, 0.499]\nedge_u = [6, 0, 0]\nedge_v = [0, "
        "6, 0]\n";
    std::vector<RayInput> rays;
    for (const double slope : {0.0, 0.001, 0.01, 0.02, 0.04}) rays.push_back({{0, 0, 0}, {slope, 0, 1}});
    for (const char* method : {"srkn6", "gauss8", "rk4", "dp54", "verlet"})
        for (const double step : {0.05, 0.11, 0.17, 0.21, 0.23, 0.3, 0.5}) {
            const auto plan =
                plan_of(scene_of("hamiltonian = \"gradient\"\nn0 = 1\ng = 2", "escape_radius = 5", object),
                        {std::string("integrator.method=") + method, "integrator.step=" + std::to_string(step),
                         "film.size=[2000,2000]"});
            const auto starts = start_rays(*plan, rays);
            std::vector<RayEnd> ends;
            trace(*plan, starts, ends);
            for (std::size_t i = 0; i < starts.size(); ++i) {
                SCOPED_TRACE(testing::Message() << method << ", step " << step << ", ray " << i);
                ASSERT_EQ(ends[i].status, Status::hit);
                const Parabola parabola{starts[i], g};
                const Double3 hit = parabola.at(parabola.first_zero([&](const Double3& q) { return lid - q[2]; }, 2));
                for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(ends[i].q[k], hit[k], 1e-6);
            }
        }
}

// Steps of length 2e3 to 1e9 are much longer than the scene. Such a step must be halved until its chord approximates
// the parabola.
TEST_P(LongSteps, ExtremelyLongStepsFindTheFloor) {
    const double g = 0.1, floor = -2;
    const std::string object =
        "[[object]]\nname = \"floor\"\nshape = \"rectangle\"\norigin = [-30, -30, -2]\nedge_u = [60, 0, 0]\nedge_v = "
        "[0, 60, 0]\n";
    std::vector<RayInput> rays;
    for (const double slope : {-0.5, -0.1, 0.0, 0.1, 0.2}) rays.push_back({{0, 0, 0}, {1, 0.2, slope}});
    for (const double step : {2e3, 2e6, 1e9}) {
        const auto plan = plan_of(scene_of("hamiltonian = \"gradient\"\nn0 = 1\ng = 0.1", "escape_radius = 30", object),
                                  {"integrator.method=srkn6", "integrator.step=" + std::to_string(step)});
        const auto starts = start_rays(*plan, rays);
        std::vector<RayEnd> ends;
        trace(*plan, starts, ends);
        for (std::size_t i = 0; i < starts.size(); ++i) {
            SCOPED_TRACE(testing::Message() << "step " << step << ", ray " << i);
            ASSERT_EQ(ends[i].status, Status::hit);
            const Parabola parabola{starts[i], g};
            const Double3 hit = parabola.at(parabola.first_zero([&](const Double3& q) { return q[2] - floor; }, 100));
            for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(ends[i].q[k], hit[k], 1e-6);
        }
    }
}

// A step may end exactly at the origin, where |q| = 0. The rays are straight, because g is negligible.
TEST_P(LongSteps, RaysContinueThroughTheOrigin) {
    for (const char* method : {"srkn6", "gauss8", "rk4"}) {
        const auto plan = plan_of(scene_of("hamiltonian = \"gradient\"\ng = 1e-300", "step = 0.25\nescape_radius = 10"),
                                  {std::string("integrator.method=") + method});
        std::vector<RayEnd> ends;
        trace(*plan, start_rays(*plan, {{{-1, 0, 0}, {1, 0, 0}}}), ends);
        ASSERT_EQ(ends[0].status, Status::escaped) << method;
        EXPECT_NEAR(ends[0].q[0], 10, 1e-9) << method;
    }
}

// The ray starts outside the escape sphere. A ball outside the sphere must neither be hit nor hide the ball inside it.
TEST_P(LongSteps, SurfacesOutsideTheEscapeSphereAreIgnored) {
    const std::string balls = "[[object]]\nname = \"far\"\nshape = \"sphere\"\ncenter = [0, -20, 0]\nradius = 1\n"
                              "[[object]]\nname = \"near\"\nshape = \"sphere\"\ncenter = [0, 0, 0]\nradius = 3\n";
    for (const char* space : {"hamiltonian = \"flat\"", "hamiltonian = \"gradient\"\ng = 0"})
        for (const double shift : {0.0, 0.5}) {
            const auto plan = plan_of(scene_of(space, "escape_radius = 10\nstep = 30", balls));
            std::vector<RayEnd> ends;
            trace(*plan, start_rays(*plan, {{{shift, -30, 0}, {0, 1, 0}}}), ends);
            SCOPED_TRACE(testing::Message() << space << ", " << shift);
            ASSERT_EQ(ends[0].status, Status::hit);
            EXPECT_EQ(plan->description().objects[ends[0].surface].name, "near");
            EXPECT_NEAR(ends[0].q[1], -std::sqrt(9 - shift * shift), 1e-9);
        }
}

// Rays that move up in the mirage are accelerated towards n = 0, and escape before it, at the edge n = n_min. A long
// step may pass over the edge and the zero of n.
TEST_P(LongSteps, RaysInTheMirageEscapeAtItsEdge) {
    constexpr double n_min = 0.05;
    for (const char* method : {"srkn6", "dp5", "gauss8", "rkf78"})
        for (const char* step : {"0.1", "0.02"}) {
            const auto plan = plan_of(scene_of("hamiltonian = \"mirage\"", std::string("step = ") + step),
                                      {std::string("integrator.method=") + method});
            std::vector<RayInput> rays;
            for (int i = 0; i < 200; ++i)
                rays.push_back({{0.01 * i, -2, 0}, {std::cos(0.7 * i), std::sin(0.7 * i), 0.4 + 0.01 * i}});
            const auto starts = start_rays(*plan, rays);
            std::vector<RayEnd> ends;
            trace(*plan, starts, ends);
            for (std::size_t i = 0; i < starts.size(); ++i) {
                SCOPED_TRACE(testing::Message() << method << ", step " << step << ", ray " << i);
                ASSERT_EQ(ends[i].status, Status::escaped) << describe(ends[i].failure);
                const double* q = ends[i].q;
                const double n = 0.85 - 0.3 * q[2] * q[2] * q[2] + 0.03 * std::cos(9.42477796076937971539 * q[0]);
                EXPECT_NEAR(n, n_min, 1e-6);
                EXPECT_GT(q[2], 1.3);
                EXPECT_NEAR(ends[i].p[1], starts[i].p[1], 1e-9);  // H does not depend on y
                const double p_squared =
                    ends[i].p[0] * ends[i].p[0] + ends[i].p[1] * ends[i].p[1] + ends[i].p[2] * ends[i].p[2];
                EXPECT_NEAR(0.5 * n * p_squared, 0.5, 0.04) << "H";
            }
        }
}

// The reported energy error must not include the error of the part of the last step that lies beyond the edge.
TEST_P(LongSteps, EnergyErrorIsThatOfTheRayUpToTheEdge) {
    Options options = with_strategy(GetParam());
    options.energy_error = true;
    const auto plan = plan_of_text(scene_of("hamiltonian = \"mirage\"", "step = 0.01"), {}, options, false);
    std::vector<RayEnd> ends;
    trace(*plan, start_rays(*plan, {{{0, -2, 0}, {0.3, 1, 0.6}}}), ends);
    EXPECT_EQ(ends[0].status, Status::escaped);
    EXPECT_LT(ends[0].energy_error, 1e-3);
}

// The default step is proportional to the size of the medium, so that rays in fisheyes of different sizes are
// geometrically similar.
TEST_P(LongSteps, FisheyesOfDifferentSizesHaveSimilarRays) {
    std::vector<RayEnd> ends[3];
    const double sizes[3] = {1, 0.01, 100};
    for (int i = 0; i < 3; ++i) {
        const double size = sizes[i];
        std::vector<RayInput> rays = rays_from({0.3 * size, -0.4 * size, 0.2 * size}, 30);
        const auto plan = plan_of(scene_of("hamiltonian = \"fisheye\"\nradius = " + std::to_string(size),
                                           "escape_radius = " + std::to_string(1.5 * size)));
        trace(*plan, start_rays(*plan, rays), ends[i]);
    }
    std::size_t escaped = 0;
    for (std::size_t k = 0; k < ends[0].size(); ++k)
        for (int i = 1; i < 3; ++i) {
            ASSERT_EQ(ends[i][k].status, ends[0][k].status);
            if (ends[0][k].status != Status::escaped) continue;
            ++escaped;
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(ends[i][k].q[c] / sizes[i], ends[0][k].q[c], 1e-9);
        }
    EXPECT_GT(escaped, 20u);
}

// The default method uses the orbit plane. The reference is another method on the general path with a fine step.
TEST_P(LongSteps, DefaultInAWormholeMatchesFineSteps) {
    std::vector<RayInput> rays;
    for (const double distance : {2.0, 4.5, 9.0})
        for (int i = 0; i < 40; ++i)
            rays.push_back({{-distance, 0, 0.6}, {1, 0.01, -0.6 / distance + 0.012 * (i - 20) / distance}});
    std::vector<RayEnd> ends, expected;
    const std::string scene = scene_of("hamiltonian = \"wormhole\"", "escape_radius = 30");
    const auto default_plan = plan_of(scene);
    const auto fine_plan = plan_of(scene, {"integrator.method=gauss16", "integrator.step=0.05"});
    trace(*default_plan, start_rays(*default_plan, rays), ends);
    trace(*fine_plan, start_rays(*fine_plan, rays), expected);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        ASSERT_EQ(ends[i].status, expected[i].status) << i;
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(ends[i].v[k], expected[i].v[k], 3e-5) << i;
        EXPECT_NEAR(ends[i].parameter, expected[i].parameter, 1e-3 * expected[i].parameter) << i;
    }
}

INSTANTIATE_TEST_SUITE_P(Strategies, LongSteps, testing::Values("scalar", "packet"),
                         [](const auto& chosen) { return std::string(chosen.param); });

}  // namespace
}  // namespace kagero::test

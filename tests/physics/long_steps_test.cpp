// Rays that end within a step, however long that is, end where they should: against parabolas, circles and edges in
// closed form.
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

std::vector<RayInput> rays_around(const Double3& position, int n) {
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

/// A ray of N² = n0² − g z: q0 + p τ − g τ²/4 ẑ.
struct Parabola {
    RayStart start;
    double g;
    Double3 at(double t) const {
        return {start.q[0] + start.p[0] * t, start.q[1] + start.p[1] * t,
                start.q[2] + start.p[2] * t - 0.25 * g * t * t};
    }
    /// The first τ where something that is positive at the start is not, to rounding; so fine a look misses no
    /// crossing.
    double first(const std::function<double(const Double3&)>& height, double limit) const {
        constexpr int looks = 20000;
        for (int i = 1; i <= looks; ++i) {
            double before = limit * (i - 1) / looks, behind = limit * i / looks;
            if (height(at(behind)) > 0) continue;
            for (int k = 0; k < 60; ++k) {
                const double middle = 0.5 * (before + behind);
                (height(at(middle)) > 0 ? before : behind) = middle;
            }
            return behind;
        }
        return std::numeric_limits<double>::infinity();
    }
};

double inside(const Double3& q, double radius) {
    return radius - std::hypot(q[0], q[1], q[2]);
}

// The escape sphere, which a thrown ray may leave and enter again within one step.
TEST_P(LongSteps, ThrownRaysLeaveTheSphereWhereTheyFirstMeetIt) {
    for (const auto& [g, radius] : {std::pair{100.0, 0.02}, std::pair{0.3, 8.0}})
        for (const char* method : {"srkn6", "gauss8", "rk4", "dp54", "rkf78"}) {
            const std::string scene = scene_of("hamiltonian = \"gradient\"\nn0 = 1.5\ng = " + std::to_string(g),
                                               "tolerance = 1e-10\nescape_radius = " + std::to_string(radius));
            const auto plan = plan_of(scene, {std::string("integrator.method=") + method});
            const auto starts = start_rays(*plan, rays_around({0, -0.25 * radius, 0.015 * radius}, 60));
            std::vector<RayEnd> ends;
            trace(*plan, starts, ends);
            for (std::size_t i = 0; i < starts.size(); ++i) {
                SCOPED_TRACE(testing::Message() << method << ", g = " << g << ", ray " << i);
                ASSERT_EQ(ends[i].status, Status::escaped);
                const double unit = plan->scene->unit;
                RayStart start = starts[i];
                for (double& x : start.q) x *= unit;
                const Parabola way{start, g};
                const double t =
                    way.first([&, radius = radius](const Double3& q) { return inside(q, radius); }, 50 * radius);
                const Double3 end = way.at(t);
                for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(ends[i].q[k], end[k], 1e-6 * radius);
                EXPECT_NEAR(ends[i].parameter, t, 1e-6 * radius);
            }
        }
}

// … and a floor, of what is not on the way out first.
TEST_P(LongSteps, ThrownRaysMeetTheFloorOnlyWhereTheyHaveNotLeft) {
    constexpr double g = 0.3, radius = 5, floor = -1, half = 20;
    const std::string objects =
        "[[object]]\nname = \"floor\"\nshape = \"rectangle\"\norigin = [-20, -20, -1]\nedge_u = [40, 0, 0]\nedge_v = "
        "[0, 40, 0]\n";
    for (const char* method : {"srkn6", "gauss8", "dp54", "rkf78"}) {
        const auto plan = plan_of(scene_of("hamiltonian = \"gradient\"\nn0 = 1.5\ng = 0.3",
                                           "tolerance = 1e-12\nescape_radius = 5", objects),
                                  {std::string("integrator.method=") + method});
        const auto starts = start_rays(*plan, rays_around({0.5, -1, 0.7}, 300));
        std::vector<RayEnd> ends;
        trace(*plan, starts, ends);
        std::size_t hits = 0, back = 0;
        for (std::size_t i = 0; i < starts.size(); ++i) {
            SCOPED_TRACE(testing::Message() << method << ", ray " << i);
            const Parabola way{starts[i], g};
            const double out = way.first([&](const Double3& q) { return inside(q, radius); }, 400);
            const double down = way.first([&](const Double3& q) { return q[2] - floor; }, 400);
            const Double3 landing = way.at(down);
            const double beside = std::max(std::abs(landing[0]), std::abs(landing[1])) - half;
            if (std::abs(beside) < 1e-6 || std::abs(out - down) < 1e-6) continue;  // at an edge
            const bool hit = beside < 0 && down < out;
            ASSERT_EQ(ends[i].status, hit ? Status::hit : Status::escaped);
            const Double3 end = hit ? landing : way.at(out);
            for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(ends[i].q[k], end[k], 1e-7);
            hits += hit, back += beside < 0 && !hit;
        }
        EXPECT_GT(hits, 20u) << method;
        EXPECT_GT(back, 20u) << method;  // that would come down on the floor if nothing ended them before
    }
}

// Where a ray turns back within a step, it is above both ends of the step, and so above the chord: as exactly as pixels
// of this size ask for.
TEST_P(LongSteps, ThrownRaysMeetALidBelowTheirTop) {
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
                const Parabola ray{starts[i], g};
                const Double3 meets = ray.at(ray.first([&](const Double3& q) { return lid - q[2]; }, 2));
                for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(ends[i].q[k], meets[k], 1e-6);
            }
        }
}

// A step a billion times as long as the scene leads there and back along a parabola that no number of chords follows.
TEST_P(LongSteps, AreHalvedWhereChordsDoNotFollowThem) {
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
            const Parabola ray{starts[i], g};
            const Double3 meets = ray.at(ray.first([&](const Double3& q) { return q[2] - floor; }, 100));
            for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(ends[i].q[k], meets[k], 1e-6);
        }
    }
}

// The origin is a place as any other, where a step may end.
TEST_P(LongSteps, RaysGoOnThroughTheOrigin) {
    for (const char* method : {"srkn6", "gauss8", "rk4"}) {
        const auto plan = plan_of(scene_of("hamiltonian = \"gradient\"\ng = 1e-300", "step = 0.25\nescape_radius = 10"),
                                  {std::string("integrator.method=") + method});
        std::vector<RayEnd> ends;
        trace(*plan, start_rays(*plan, {{{-1, 0, 0}, {1, 0, 0}}}), ends);
        ASSERT_EQ(ends[0].status, Status::escaped) << method;
        EXPECT_NEAR(ends[0].q[0], 10, 1e-9) << method;
    }
}

// What lies beyond the escape sphere neither stops a ray nor hides what lies within.
TEST_P(LongSteps, SurfacesBeyondTheSphereHideNothing) {
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

// Light that goes up in the mirage runs ever faster against n = 0, and ends where n = n_min: a long step may leap over
// both.
TEST_P(LongSteps, MirageEndsAtItsEdge) {
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
                EXPECT_NEAR(ends[i].p[1], starts[i].p[1], 1e-9);  // nothing depends on y
                const double square =
                    ends[i].p[0] * ends[i].p[0] + ends[i].p[1] * ends[i].p[1] + ends[i].p[2] * ends[i].p[2];
                EXPECT_NEAR(0.5 * n * square, 0.5, 0.04) << "H";
            }
        }
}

// What is told of H is what the ray loses, not what a step beyond the edge would.
TEST_P(LongSteps, EnergyErrorsStopAtTheEdge) {
    Options options = with_strategy(GetParam());
    options.energy_error = true;
    const auto plan = plan_of_text(scene_of("hamiltonian = \"mirage\"", "step = 0.01"), {}, options, false);
    std::vector<RayEnd> ends;
    trace(*plan, start_rays(*plan, {{{0, -2, 0}, {0.3, 1, 0.6}}}), ends);
    EXPECT_EQ(ends[0].status, Status::escaped);
    EXPECT_LT(ends[0].energy_error, 1e-3);
}

// The default step goes with the medium: the same fisheye, of any size, has the same circles.
TEST_P(LongSteps, FisheyesOfAnySizeHaveTheSameRays) {
    std::vector<RayEnd> ends[3];
    const double sizes[3] = {1, 0.01, 100};
    for (int i = 0; i < 3; ++i) {
        const double size = sizes[i];
        std::vector<RayInput> rays = rays_around({0.3 * size, -0.4 * size, 0.2 * size}, 30);
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

// The default, in the plane of the orbit, against the general path by another method.
TEST_P(LongSteps, WormholesAreCrossedByTheDefaultAsByAFineStep) {
    std::vector<RayInput> rays;
    for (const double distance : {2.0, 4.5, 9.0})
        for (int i = 0; i < 40; ++i)
            rays.push_back({{-distance, 0, 0.6}, {1, 0.01, -0.6 / distance + 0.012 * (i - 20) / distance}});
    std::vector<RayEnd> by_default, finely;
    const std::string scene = scene_of("hamiltonian = \"wormhole\"", "escape_radius = 30");
    const auto own = plan_of(scene), fine = plan_of(scene, {"integrator.method=gauss16", "integrator.step=0.05"});
    trace(*own, start_rays(*own, rays), by_default), trace(*fine, start_rays(*fine, rays), finely);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        ASSERT_EQ(by_default[i].status, finely[i].status) << i;
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(by_default[i].v[k], finely[i].v[k], 3e-5) << i;
        EXPECT_NEAR(by_default[i].parameter, finely[i].parameter, 1e-3 * finely[i].parameter) << i;
    }
}

INSTANTIATE_TEST_SUITE_P(Strategies, LongSteps, testing::Values("scalar", "packet"),
                         [](const auto& chosen) { return std::string(chosen.param); });

}  // namespace
}  // namespace kagero::test

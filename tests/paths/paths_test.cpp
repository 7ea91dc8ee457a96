// Paths through several surfaces: touching and nested boundaries, a camera inside a medium, random branches, limits on
// the number of surfaces, the points of paths, and the counters of generations.
#include "tests/support/plan_fixture.h"

#include "accuracy/ray_errors.h"
#include "film/write_film.h"
#include "paths/fresnel.h"
#include "render/render.h"
#include "scene/vector3.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace kagero::test {
namespace {

const std::string flat_space = "[space]\nhamiltonian = \"flat\"\n[integrator]\nescape_radius = 60\n";
const std::string glass_and_water =
    "[[medium]]\nname = \"glass\"\nhamiltonian = \"uniform\"\nn0 = 1.5\n"
    "[[medium]]\nname = \"water\"\nhamiltonian = \"uniform\"\nn0 = 1.33\n";

/// Returns a camera at (0, −5, 0) that looks along +y, with a film of the given size.
std::string camera(const std::string& size, const std::string& film = "", const std::string& keys = "") {
    return "[camera]\nposition = [0, -5, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\nfov = 20\n" + keys +
           "[film]\nsize = " + size + "\n" + film;
}

/// Returns a box with the given z range as a boundary.
std::string slab(const std::string& name, double low, double high, const std::string& interior,
                 const std::string& exterior = "space") {
    return "[[object]]\nname = \"" + name + "\"\nshape = \"box\"\nmin = [-9, -9, " + std::to_string(low) +
           "]\nmax = [9, 9, " + std::to_string(high) + "]\nmaterial = \"boundary\"\ninterior = \"" + interior +
           "\"\nexterior = \"" + exterior + "\"\nfresnel = \"transmit\"\n";
}

struct Traced {
    std::vector<RayEnd> ends;
    std::vector<PathState> paths;
};

Traced trace_text(const std::string& text, const std::vector<RayInput>& rays, std::uint32_t bounces) {
    Options options;
    options.bounces = bounces;
    const auto plan = plan_of_text(text + camera("[4, 4]"), {}, options, false);
    Traced traced;
    trace(*plan, start_rays(*plan, rays), traced.ends, {}, &traced.paths);
    return traced;
}

/// Returns the directions of rays at several angles to the z axis, downward.
std::vector<RayInput> falling_rays(double height) {
    std::vector<RayInput> rays;
    for (int degrees = 0; degrees < 60; degrees += 7) {
        const double a = degrees * std::numbers::pi / 180;
        rays.push_back({{0.013 * degrees, 0.02, height}, {std::sin(a), 0.1 * std::sin(a), -std::cos(a)}});
    }
    return rays;
}

// Light passes from glass directly into water where the two touch. A gap between them would reflect it totally beyond
// the critical angle of glass, 41.8 degrees.
TEST(Paths, CrossTouchingBoundariesAtOnce) {
    const std::string scene =
        flat_space + glass_and_water + slab("glass", 0, 2, "glass") + slab("water", -2, 0, "water");
    const std::vector<RayInput> rays = falling_rays(1);
    const Traced traced = trace_text(scene, rays, 1);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        EXPECT_EQ(traced.paths[i].medium, 2u) << i;
        const Double3 d = unit(rays[i].direction);
        const double* v = traced.ends[i].v;
        EXPECT_NEAR(v[0], 1.5 / 1.33 * d[0], 1e-12);
        EXPECT_NEAR(v[1], 1.5 / 1.33 * d[1], 1e-12);
        EXPECT_LT(v[2], 0);
        EXPECT_NEAR(traced.paths[i].weight[0], std::pow(1.5 / 1.33, 2), 1e-12);
    }
}

// The bubble of air in a slab of glass in water: each surface divides the media that it states.
TEST(Paths, PassNestedBoundaries) {
    const std::string bubble =
        "[[object]]\nname = \"bubble\"\nshape = \"sphere\"\ncenter = [0, 0, 1]\nradius = 0.5\nmaterial = \"boundary\"\n"
        "interior = \"space\"\nexterior = \"glass\"\nfresnel = \"transmit\"\n";
    const std::string scene =
        flat_space + glass_and_water + slab("pool", -4, 4, "water") + slab("block", 0, 2, "glass", "water") + bubble;
    const Traced traced = trace_text(scene, {{{0, 0, 9}, {0, 0, -1}}, {{2, 0, 9}, {0, 0, -1}}}, 6);
    EXPECT_EQ(traced.paths[0].bounces, 6u);
    EXPECT_EQ(traced.paths[1].bounces, 4u);
    for (const std::size_t i : {0u, 1u}) {
        EXPECT_EQ(traced.ends[i].status, Status::escaped);
        EXPECT_EQ(traced.paths[i].medium, 0u);
        EXPECT_NEAR(traced.ends[i].v[2], -1, 1e-15);
    }
}

// A camera under water sees the sky in Snell's window, within asin(1/1.33) of the vertical. The medium of the camera
// and of single rays is found by casting rays.
TEST(Paths, StartInTheMediumAroundTheCamera) {
    const std::string scene =
        flat_space + glass_and_water + slab("pool", -9, 1, "water") + "[sky]\ncolor = [1, 1, 1]\n";
    const auto plan =
        plan_of_text(scene +
                         "[camera]\nposition = [0, 0, 0]\nlook_at = [0, 0, 1]\nup = [0, 1, 0]\nfov = 120\n"
                         "[film]\nsize = [65, 65]\nlayers = [\"color\", \"status\"]\n",
                     {});
    EXPECT_EQ(plan->view.medium, 2u);
    Film film = film_of(*plan);
    render(*plan, film);
    const float* color = film.plane("color");
    const auto brightness = [&](int x, int y) { return color[3 * (65 * y + x)]; };
    EXPECT_NEAR(brightness(32, 32), 1.33 * 1.33, 1e-5);  // straight up: radiance times the squared index
    const double edge = std::asin(1 / 1.33);
    std::vector<RayInput> rays;
    for (const double offset : {-1e-6, 1e-6})
        rays.push_back({{0, 0, 0}, {std::sin(edge + offset), 0, std::cos(edge + offset)}});
    const Traced traced = trace_text(scene, rays, 1);
    EXPECT_EQ(traced.paths[0].medium, 0u);
    EXPECT_EQ(traced.paths[1].medium, 2u);
}

// With several rays per pixel, each takes a random branch. The mean over many pixels is that of both branches.
TEST(Paths, TakeRandomBranchesWithTheProbabilityOfTheirShares) {
    const std::string lamp =
        "[[object]]\nname = \"lamp\"\nshape = \"rectangle\"\norigin = [-9, 1, -9]\nedge_u = [18, 0, 0]\n"
        "edge_v = [0, 0, 18]\ncolor = [1, 1, 1]\n";
    const std::string pane =
        "[[object]]\nname = \"pane\"\nshape = \"box\"\nmin = [-9, -0.5, -9]\nmax = [9, 0.5, 9]\n"
        "material = \"boundary\"\ninterior = \"glass\"\ntint = [1, 0.9, 1]\n";
    const auto plan =
        plan_of_text(flat_space + glass_and_water + pane + lamp +
                         camera("[32, 32]", "spp = 64\nmax_bounces = 30\n", "type = \"orthographic\"\nheight = 1\n"),
                     {"camera.fov=60"});
    Film film = film_of(*plan);
    const RunReport report = render(*plan, film);
    const float* color = film.plane("color");
    double mean[3] = {0, 0, 0};
    for (int i = 0; i < 32 * 32; ++i)
        for (int k = 0; k < 3; ++k) mean[k] += color[3 * i + k] / (32 * 32);
    // A pane with two surfaces of reflectance R transmits (1 − R)² Σ R^(2k), which is (1 − R)/(1 + R) without tint.
    const double r = reflectance({1, 1}, {1.5, 1}), tint = 0.9;
    EXPECT_NEAR(r, 0.04, 1e-15);
    const double error = 4 * std::sqrt(r / (32.0 * 32 * 64));
    EXPECT_NEAR(mean[0], (1 - r) / (1 + r), error);
    EXPECT_NEAR(mean[1], tint * tint * (1 - r) * (1 - r) / (1 - r * r * tint * tint), error);
    EXPECT_NEAR(double(report.path_lengths.bounces) / double(report.rays), 2 * (1 - r) + r * (1 + 2 * r), 0.05);
}

/// Two mirrors that face each other, at y = 0 and y = 2.
const std::string mirrors =
    "[[object]]\nname = \"far\"\nshape = \"rectangle\"\norigin = [-9, 2, -9]\nedge_u = [18, 0, 0]\nedge_v = [0, 0, "
    "18]\n"
    "material = \"mirror\"\ntint = [0.5, 0.25, 1]\n"
    "[[object]]\nname = \"near\"\nshape = \"rectangle\"\norigin = [-9, 0, -9]\nedge_u = [18, 0, 0]\nedge_v = [0, 0, "
    "18]\n"
    "material = \"mirror\"\ntint = [0.5, 0.25, 1]\n";

TEST(Paths, EndAfterTheGreatestNumberOfSurfaces) {
    const RayInput ray{{0, 1, 0}, {0.01, 1, 0}};
    const Traced traced = trace_text(flat_space + mirrors, {ray}, 7);
    EXPECT_EQ(traced.ends[0].status, Status::step_limit);
    EXPECT_TRUE(traced.ends[0].cut_off);
    EXPECT_EQ(traced.paths[0].bounces, 7u);
    EXPECT_NEAR(traced.paths[0].weight[0], std::pow(0.5, 7), 1e-15);
    EXPECT_NEAR(traced.paths[0].weight[1], std::pow(0.25, 7), 1e-15);
    EXPECT_NEAR(traced.ends[0].q[0], 0.01 * 15, 1e-14);  // 1 to the first mirror, then 7 times 2
    EXPECT_NEAR(traced.ends[0].parameter, 15 * std::hypot(1, 0.01), 1e-13);
}

TEST(Paths, ArePathsOfPointsWithOneSegmentPerSurface) {
    Options options;
    options.bounces = 3;
    options.parameter = true;
    const auto plan = plan_of_text(flat_space + mirrors + camera("[4, 4]"), {}, options, false);
    std::vector<RayEnd> ends;
    const std::vector<PathPoint> points = trace_paths(*plan, start_rays(*plan, {{{0, 1, 0}, {0, 1, 0}}}), ends);
    ASSERT_EQ(points.size(), 8u);  // the start and the end of four segments
    double expected_y[] = {1, 2, 2, 0, 0, 2, 2, 0}, expected_parameter[] = {0, 1, 1, 3, 3, 5, 5, 7};
    for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_EQ(points[i].segment, i / 2);
        EXPECT_EQ(points[i].step, (i + 1) / 2);
        EXPECT_NEAR(points[i].q[1], expected_y[i], 1e-14);
        EXPECT_NEAR(points[i].parameter, expected_parameter[i], 1e-13);
    }
}

// The counters of a picture count paths by their ends, and each generation of rays.
TEST(Paths, AreCountedByGeneration) {
    const auto plan = plan_of_text(flat_space + mirrors + camera("[40, 40]", "max_bounces = 3\n"), {});
    Film film = film_of(*plan);
    const RunReport report = render(*plan, film);
    // The camera is outside, at y = −5: its rays meet the back of the mirror `near`, and leave.
    ASSERT_EQ(report.generations.size(), 2u);
    EXPECT_EQ(report.generations[0].rays, 1600u);
    EXPECT_EQ(report.generations[1].rays, 1600u);
    EXPECT_EQ(report.counters.ended[static_cast<int>(Status::escaped)], 1600u);
    EXPECT_EQ(report.counters.ended[static_cast<int>(Status::hit)], 0u);
    EXPECT_EQ(report.path_lengths.bounces, 1600u);
    EXPECT_EQ(report.path_lengths.cut_off, 0u);
}

// A ball of graded glass that is integrated with long steps, in a space of straight rays: the estimated errors of the
// paths are close to the distances from the ends of precise paths. The program states that the bound on the pixel error
// does not include the ball.
TEST(Paths, HaveEstimatedErrorsFromAllMedia) {
    const auto scene = [](const std::string& integrator) {
        return flat_space + "[[medium]]\nname = \"graded\"\nhamiltonian = \"fisheye\"\nn0 = 1.6\nradius = 2\n" +
               integrator +
               "[[object]]\nname = \"ball\"\nshape = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\nfresnel = "
               "\"transmit\"\n"
               "material = \"boundary\"\ninterior = \"graded\"\n" +
               camera("[24, 24]", "layers = [\"color\", \"position_error\"]\n");
    };
    const auto coarse = plan_of_text(scene("[medium.integrator]\nmethod = \"rk4\"\nstep = 0.4\n"), {}),
               precise = plan_of_text(scene(""), {});
    EXPECT_EQ(std::count_if(coarse->remarks.begin(), coarse->remarks.end(),
                            [](const std::string& remark) { return remark.find("medium.graded") != remark.npos; }),
              1);
    EXPECT_TRUE(precise->remarks.empty());
    Film film = film_of(*coarse);
    render_with_errors(*coarse, film);
    std::vector<RayStart> starts;
    for (std::uint32_t i = 0; i < 24 * 24; ++i) starts.push_back(pixel_ray_start(*coarse, i % 24, i / 24));
    std::vector<RayEnd> coarse_ends, precise_ends;
    std::vector<PathState> paths;
    trace(*coarse, starts, coarse_ends, {}, &paths);
    trace(*precise, starts, precise_ends);
    int through_ball = 0, close = 0;
    for (std::size_t i = 0; i < starts.size(); ++i) {
        if (paths[i].bounces == 0) continue;
        ++through_ball;
        const double error = pixel_error(*coarse, precise_ends[i], coarse_ends[i]),
                     estimate = film.plane("position_error")[i];
        close += estimate > error / 3 && estimate < 3 * error;
    }
    EXPECT_GT(through_ball, 100);
    EXPECT_GE(close, 0.9 * through_ball);
}

// The film does not depend on threads, although branches are random.
TEST(Paths, DoNotDependOnThreads) {
    const std::string ball =
        "[[object]]\nname = \"ball\"\nshape = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\n"
        "material = \"boundary\"\ninterior = \"glass\"\n";
    std::vector<float> pictures[2];
    for (const unsigned threads : {1u, 3u}) {
        Options options;
        options.threads = threads;
        const auto plan = plan_of_text(flat_space + glass_and_water + ball + "[sky]\nchecker = true\n" +
                                           camera("[70, 50]", "spp = 4\n"),
                                       {}, options);
        Film film = film_of(*plan);
        render(*plan, film);
        const float* color = film.plane("color");
        pictures[threads / 3].assign(color, color + 3 * 70 * 50);
    }
    EXPECT_EQ(pictures[0], pictures[1]);
}

}  // namespace
}  // namespace kagero::test

// Keys that cannot change the ends of the rays of a sweep are reported, and they change no bit of them.
#include "sweep/unread_keys.h"
#include "sweep/sweep.h"

#include "scene/value.h"
#include "tests/support/plan_fixture.h"
#include "tuning/resolve.h"

#include <gtest/gtest.h>

#include <cstring>

namespace kagero::test {
namespace {

/// A scene with a disk, a textured and a plain surface, and skies.
constexpr const char* scene = R"([space]
hamiltonian = "schwarzschild"
rg = 0.5
[integrator]
escape_radius = 40
[camera]
position = [0, -12, 3]
look_at = [0, 0, 0]
up = [0, 0, 1]
[film]
size = [64, 48]
[sky]
checker = true
[[object]]
name = "disk"
shape = "disk"
center = [0, 0, 0]
inner = 2
outer = 6
temperature = 4500
)"
                              R"([[object]]
name = "ball"
shape = "sphere"
center = [3, 3, 2]
radius = 1.5
[[object]]
name = "left wall"
shape = "rectangle"
origin = [-8, -8, -8]
edge_u = [0, 16, 0]
edge_v = [0, 0, 16]
[animation]
frames = 24
[animation.set]
"object.ball.radius" = "1.5 + 0.5*u + w + s"
)";

PlanWithOverrides plan_with(const std::string& text, const Options& options) {
    return [=](const std::vector<std::string>& overrides) {
        const Overrides keys(overrides.begin(), overrides.end());
        return resolve(load_scene_text(text, "sweep.toml", keys, catalogue(options.isa), SceneUse::single_rays),
                       options, Purpose::ray_list);
    };
}

std::vector<RayInput> many_rays() {
    std::vector<RayInput> rays;
    for (int i = 0; i < 200; ++i)
        rays.push_back({{-7.5, 0.07 * (i - 100), 0.03 * (i % 70) - 1}, {1, 0.002 * (i % 31), -0.01 * (i % 7)}});
    return rays;
}

/// Returns the ends of the rays for a list of overrides, as bytes.
std::string ends_with(const PlanWithOverrides& plan_of, const std::vector<std::string>& overrides) {
    const Plan plan = plan_of(overrides);
    std::vector<RayEnd> ends;
    trace(plan, start_rays(plan, many_rays(), {}), ends);
    std::string bytes;
    for (const RayEnd& end : ends) {
        const double numbers[] = {
            end.q[0],         end.q[1],      end.q[2],          end.v[0],           end.v[1],
            end.v[2],         end.p[0],      end.p[1],          end.p[2],           end.pt,
            end.energy_error, end.parameter, double(end.steps), double(end.status), double(end.surface)};
        bytes.append(reinterpret_cast<const char*>(numbers), sizeof numbers);
    }
    return bytes;
}

Options ray_options() {
    Options options;
    options.energy_error = options.parameter = true;
    options.threads = 2;
    return options;
}

TEST(UnreadKeys, ChangeNoBitAndAreReported) {
    const std::vector<std::array<std::string, 2>> overrides{
        {"camera.fov=10", "camera.fov=80"},
        {"camera.position=[0, -9, 1]", "camera.position=[20, 2, 1]"},
        {"camera.look_at=[0, 1, 0]", "camera.look_at=[0, 0, 9]"},
        {"camera.up=[0, 0, 1]", "camera.up=[1, 0, 1]"},
        {"camera.type=equirectangular", "camera.type=orthographic"},
        {"camera.observer=static", "camera.observer=falling"},
        {"camera.aperture_radius=0.1", "camera.aperture_radius=0.3"},
        {"camera.focus_distance=1", "camera.focus_distance=9"},
        {"camera.shutter=0", "camera.shutter=0.5"},
        {"film.size=[2, 2]", "film.size=[4000, 3000]"},
        {"film.spp=1", "film.spp=64"},
        {"film.seed=1", "film.seed=2"},
        {"film.max_bounces=0", "film.max_bounces=20"},
        {"film.exposure=-1", "film.exposure=3"},
        {"film.tone=clip", "film.tone=filmic"},
        {"film.sampling=full", "film.sampling=adaptive"},
        {"film.max_interpolation_error=0.1", "film.max_interpolation_error=0.5"},
        {"film.layers=[\"color\"]", "film.layers=[\"steps\", \"depth\"]"},
        {"sky.checker=true", "sky.checker=false"},
        {"sky.pole=[0, 0, 1]", "sky.pole=[0, 1, 0]"},
        {"animation.frames=1", "animation.frames=1000"},
        {"animation.fps=1", "animation.fps=60"},
        {"object.disk.temperature=1000", "object.disk.temperature=9000"},
        {"object.\"left wall\".color=[1, 0, 0]", "object.\"left wall\".color=[0, 0, 1]"},
        {"object.ball.shading=emission", "object.ball.shading=lambert"},
        {"integrator.max_pixel_error=0.001", "integrator.max_pixel_error=10"},
        {"integrator.cull=auto", "integrator.cull=none"},
        {"integrator.refill=on", "integrator.refill=off"},
    };
    const PlanWithOverrides plan_of = plan_with(scene, ray_options());
    for (const auto& [first, second] : overrides) {
        EXPECT_TRUE(ends_with(plan_of, {first}) == ends_with(plan_of, {second})) << first << " and " << second;
        const auto remarks = remarks_on_unread_keys(plan_of({first}), {first});
        ASSERT_EQ(remarks.size(), 1u) << first;
        EXPECT_EQ(remarks[0].find(first.substr(0, first.find('=')) + " has no effect on this sweep: "), 0u)
            << remarks[0];
    }
}

// With a fixed step, the tolerance is not used; with an explicit method, no equations are solved.
TEST(UnreadKeys, DependOnTheMethod) {
    const PlanWithOverrides plan_of = plan_with(scene, ray_options());
    const std::string fixed = "integrator.method=rk4", adaptive = "integrator.method=dp85",
                      implicit = "integrator.method=gauss4", step = "integrator.step=0.05";
    const auto remarks = [&](const std::string& method, const std::string& key) {
        return remarks_on_unread_keys(plan_of({method, step}), {key}).size();
    };
    for (const std::string key : {"integrator.tolerance", "integrator.solver_tolerance"}) {
        EXPECT_EQ(remarks(fixed, key), 1u) << key;
        EXPECT_TRUE(ends_with(plan_of, {fixed, step, key + "=1e-3"}) ==
                    ends_with(plan_of, {fixed, step, key + "=1e-9"}))
            << key;
        EXPECT_EQ(remarks_on_unread_keys(plan_of({fixed, step}), {key, "integrator.method"}).size(), 0u);
    }
    EXPECT_EQ(remarks(adaptive, "integrator.tolerance"), 0u);
    EXPECT_FALSE(ends_with(plan_of, {adaptive, "integrator.tolerance=1e-3"}) ==
                 ends_with(plan_of, {adaptive, "integrator.tolerance=1e-9"}));
    EXPECT_EQ(remarks(implicit, "integrator.solver_tolerance"), 0u);
}

TEST(UnreadKeys, AreNotThoseThatCanChangeRays) {
    const PlanWithOverrides plan_of = plan_with(scene, ray_options());
    const std::vector<std::array<std::string, 2>> overrides{
        {"space.rg=0.5", "space.rg=0.6"},
        {"integrator.escape_radius=40", "integrator.escape_radius=50"},
        {"integrator.max_steps=3", "integrator.max_steps=1000"},
        {"object.ball.radius=1.5", "object.ball.radius=2"},
        {"object.disk.outer=6", "object.disk.outer=7"},
    };
    for (const auto& [first, second] : overrides) {
        EXPECT_FALSE(ends_with(plan_of, {first}) == ends_with(plan_of, {second})) << first << " and " << second;
        EXPECT_TRUE(remarks_on_unread_keys(plan_of({first}), {first}).empty()) << first;
    }
    // Trial rays of the camera choose the bound on the steps of a formula.
    const std::string formula = "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2)\"\nH0 = 0.5\n";
    EXPECT_TRUE(remarks_on_unread_keys(plan_with(formula, ray_options())({}), {"camera.fov"}).empty());
    // Paths depend on the paints of surfaces, and on the seed of random directions.
    Options paths = ray_options();
    paths.bounces = 3;
    const Plan plan = plan_with(scene, paths)({});
    EXPECT_TRUE(remarks_on_unread_keys(plan, {"film.seed", "object.ball.color"}).empty());
    EXPECT_EQ(remarks_on_unread_keys(plan, {"camera.fov"}).size(), 1u);
}

TEST(UnreadKeys, AreReportedByASweep) {
    const SweepResult result =
        sweep(plan_with(scene, ray_options()), {{"space.rg", {0.4, 0.5}}, {"camera.fov", {10, 20}}}, many_rays());
    EXPECT_EQ(result.remarks, (std::vector<std::string>{"camera.fov has no effect on this sweep: rays of a list do not "
                                                        "start at the camera; leave the key out"}));
}

}  // namespace
}  // namespace kagero::test

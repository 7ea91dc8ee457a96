// Tests of the keys that state velocities, and of far_domain.
#include "tests/support/velocity_scenes.h"

#include "scene/print.h"
#include "scene/vector3.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kagero::test {
namespace {

const std::string wormhole = R"toml([space]
hamiltonian = "formula"
H = "0.5*((px^2 + py^2 + pz^2)/(1 + a^2/(4*R^2))^2 - pt^2)"
domain = "l + 40"
far_domain = "l"
[space.constants]
pt = 1
a = 1
[space.let]
R = "sqrt(x^2 + y^2 + z^2)"
l = "R - a^2/(4*R)"
[integrator]
escape_radius = 40
[camera]
position = [0, -5, 0.3]
look_at = [0, 0, 0]
up = [0, 0, 1]
fov = 30
[film]
size = [12, 8]
[sky.far]
checker = true
)toml";

TEST(FarDomain, ShowsTheSameSkiesAsTheBuiltInWormhole) {
    if (!is_available("wormhole")) GTEST_SKIP() << "the kernel modules were built without wormhole";
    std::string built_in_text = wormhole;
    built_in_text.replace(0, wormhole.find("[integrator]"), "[space]\nhamiltonian = \"wormhole\"\nthroat = 1\n");
    const Overrides accurate{"integrator.tolerance=1e-10", "integrator.method=dp85"};
    const auto formula = plan_of_text(wormhole, accurate), built_in = plan_of_text(built_in_text, accurate);
    int far = 0;
    for (std::uint32_t y = 0; y < 8; ++y)
        for (std::uint32_t x = 0; x < 12; ++x) {
            SkyView views[2];
            for (const Plan* plan : {formula.get(), built_in.get()}) {
                std::vector<RayEnd> ends;
                trace(*plan, {camera_ray_start(*plan, x + 0.5, y + 0.5)}, ends);
                views[plan == built_in.get()] = sky_view(plan->scene->sources.skies, ends[0]);
            }
            far += views[0].on_second_sheet;
            EXPECT_EQ(views[0].on_second_sheet, views[1].on_second_sheet);
            EXPECT_LE(length(subtract(views[0].direction, views[1].direction)), 1e-3);  // the ends differ slightly
        }
    EXPECT_GT(far, 8);
    EXPECT_LT(far, 80);
}

// The other universe of this flat space is the half-space y > 20: rays move outward there, so they are not reflected.
TEST(FarDomain, KeepsTheDirectionOfRaysThatMoveOutward) {
    const auto plan = plan_of_text(wormhole, {"space.constants.a=0", "space.far_domain=20 - y", "space.domain=40 - R",
                                          "camera.look_at=[9,9,3]"});
    const CentralRay ray = central_ray(*plan);
    EXPECT_TRUE(ray.sky.on_second_sheet);
    EXPECT_FALSE(ray.sky.reflected);
    EXPECT_LE(length(subtract(ray.sky.direction, plan->view.forward)), 1e-9);
}

TEST(Velocities, AreRefusedWithTheirValueAndTheLegalForm) {
    const std::string text = schwarzschild + camera + disk;
    for (const auto& [key, part] : {
             std::pair{"camera.velocity=[0,1.5,0]",
                       "camera.velocity = [0, 1.5, 0] at camera.position = [0, -29.5, 5.2] is not slower than light: "
                       "in this direction, the speed"},
             {"camera.velocity=[0,\"R\",0]", "[0, \"R\", 0] = [0, 29.9"},
             {"camera.velocity=3", "camera.velocity = 3 is not legal: it must be an array of 3 numbers or formulas"},
             {"camera.velocity=[1,2,true]", "camera.velocity[2] = true is not legal"},
             {"camera.velocity=[0,\"pz\",0]", "depends on pz; it may depend only on x y z"},
             {"camera.velocity=[0,\"RR\",0]", "unknown name RR; did you mean R?"},
             {"space.sky_frame=[2,0,0]", "space.sky_frame = [2, 0, 0] is not slower than light at"},
             {"space.sky_frame=[\"sqrt(-x^2)\",0,0]", "each component must be a finite number"},
             {"object.disk.velocity=[3,0,0]", "object.disk.velocity = [3, 0, 0] is not slower than light at"},
             {"sky.far.checker=true", "state space.far_domain, or remove the table [sky.far]"}})
        EXPECT_NE(refusal(text, {key}).find(part), std::string::npos) << key << ": " << refusal(text, {key});
    EXPECT_NE(refusal(text, {"camera.velocity=[0,0,0]", "camera.observer=static"})
                  .find("camera.velocity = [0, 0, 0] and camera.observer = \"static\" exclude each other"),
              std::string::npos);
    EXPECT_NE(refusal(text, {"camera.velocity=[0,0,0]", "camera.position=[0.5,0,0]"}).find("nothing can be at rest"),
              std::string::npos);
    const std::string medium = "[space]\nhamiltonian = \"fisheye\"\n" + camera;
    for (const char* key : {"camera.velocity=[0,0,0]", "space.sky_frame=[0,0,0]"})
        EXPECT_NE(refusal(medium, {key}).find("legal only in a spacetime"), std::string::npos) << key;
}

// A river of space that flows outward with the speed 0.1 |q|, as in de Sitter's universe. Rays end at the distance 9.
// The escape sphere is beyond the horizon, where nothing can be at rest.
TEST(Velocities, OfTheSkyAreComparedWithLightAtTheEdgeOfTheDomain) {
    const std::string text = R"toml([space]
hamiltonian = "formula"
H = "0.5*(px^2 + py^2 + pz^2 - (pt + 0.1*(x*px + y*py + z*pz))^2)"
domain = "9 - sqrt(x^2 + y^2 + z^2)"
[space.constants]
pt = 1
)toml" + camera;
    const Overrides inside{"camera.position=[0,0,0]", "camera.look_at=[1,0,0]"};
    const auto remarks_with = [&](const char* frame) {
        Overrides keys = inside;
        keys.emplace_back(std::string("space.sky_frame=") + frame);
        return plan_of_text(text, keys)->remarks;
    };
    EXPECT_TRUE(remarks_with("[0,0,0]").empty());
    EXPECT_TRUE(remarks_with("[\"0.1*x\",\"0.1*y\",\"0.1*z\"]").empty());
    const auto remarks = remarks_with("[0.5,0,0]");
    ASSERT_EQ(remarks.size(), 1u);
    EXPECT_NE(remarks[0].find("space.sky_frame = [0.5, 0, 0] is not slower than light at ["), std::string::npos);
    EXPECT_THROW(remarks_with("[0,9,0]"), InputError);
}

TEST(Velocities, ArePrintedAsTheyAreWritten) {
    const Overrides keys{"space.sky_frame=[0,\"x*rg/1e9\",1e-3]", "camera.velocity=[0,\"0.1\",0]",
                         "object.disk.velocity=[\"-y*rg/R^3\",0.01,0]", "space.far_domain=R - 1"};
    const std::string text = schwarzschild + camera + disk;
    const auto plan = plan_of_text(text, keys);
    EXPECT_TRUE(plan->remarks.empty()) << plan->remarks.front();
    const std::string printed = print_scene(load_scene_text(text, "scene.toml", keys, catalogue("auto")));
    for (const char* line : {"\nsky_frame = [0, \"x*rg/1e9\", 0.001]\n", "\nvelocity = [0, \"0.1\", 0]\n",
                             "\nvelocity = [\"-y*rg/R^3\", 0.01, 0]\n", "\nfar_domain = \"R - 1\"\n", "\n[sky.far]\n"})
        EXPECT_NE(printed.find(line), std::string::npos) << line;
    EXPECT_EQ(printed.find("observer"), std::string::npos);
    EXPECT_EQ(print_scene(load_scene_text(printed, "scene.toml", {}, catalogue("auto"))), printed);
}

}  // namespace
}  // namespace kagero::test

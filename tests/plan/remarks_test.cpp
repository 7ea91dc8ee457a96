// Tests of remarks on keys without effect and on objects that are not visible.
#include "tests/support/plan_fixture.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace kagero::test {
namespace {

const std::string view = R"([camera]
position = [4, 0, 1]
look_at = [0, 0, 0]
up = [0, 0, 1]
[film]
size = [8, 6]
)";

const std::string ball = "[space]\nhamiltonian = \"schwarzschild\"\n" + view + R"([[object]]
name = "ball"
shape = "sphere"
center = [0, 3, 0]
radius = 0.75
)";

const std::string disk_in_a_formula =
    "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - 1)\"\n" + view + R"([[object]]
name = "ring"
shape = "disk"
center = [0, 0, 0]
normal = [0, 0, 1]
inner = 1
outer = 2
)";

/// Returns true if a remark of the plan contains `part`.
bool has_remark(const Plan& plan, const std::string& part) {
    return std::any_of(plan.remarks.begin(), plan.remarks.end(),
                       [&](const std::string& remark) { return remark.find(part) != std::string::npos; });
}

// Each remark must be made for a scene with the overrides `with_remark`, and not for one with `without_remark`.
TEST(Remarks, AreMadeOnInvisibleObjectsAndUnusedKeys) {
    struct {
        const char* part;
        Overrides with_remark, without_remark;
    } const cases[] = {
        {"object.ball is not visible", {"object.ball.center=[0,60,0]"}, {"object.ball.center=[0,50,0]"}},
        {"object.ball is not visible",
         {"object.ball.center=[0,0,0]", "object.ball.radius=60"},
         {"object.ball.center=[0,40,0]", "object.ball.radius=60"}},
        {"camera.fov has no effect", {"camera.fov=50", "camera.type=orthographic"}, {"camera.fov=50"}},
        {"camera.fov has no effect", {"camera.fov=50", "camera.type=equirectangular"}, {"camera.type=equirectangular"}},
        {"integrator.tolerance has no effect",
         {"integrator.tolerance=1e-6", "integrator.method=rk4"},
         {"integrator.tolerance=1e-6"}},
        {"integrator.solver_tolerance has no effect",
         {"integrator.solver_tolerance=1e-6", "integrator.method=rk4"},
         {"integrator.solver_tolerance=1e-6", "integrator.method=gauss8"}},
        {"camera.focus_distance has no effect",
         {"camera.focus_distance=2"},
         {"camera.focus_distance=2", "camera.aperture_radius=0.1"}},
        {"the lens of camera.aperture_radius makes noise",
         {"camera.aperture_radius=0.1"},
         {"camera.aperture_radius=0.1", "film.spp=4"}},
        {"the layer standard_error is nan",
         {"film.layers=[\"color\",\"standard_error\"]"},
         {"film.layers=[\"color\",\"standard_error\"]", "film.spp=4"}},
    };
    for (const auto& [part, with_remark, without_remark] : cases) {
        EXPECT_TRUE(has_remark(*plan_of_text(ball, with_remark), part)) << part;
        EXPECT_FALSE(has_remark(*plan_of_text(ball, without_remark), part)) << part;
    }
}

TEST(Remarks, AreMadeOnFormulasThatEndAllRaysAtTheCamera) {
    for (const std::string key : {"space.capture", "space.domain"}) {
        SCOPED_TRACE(key);
        EXPECT_TRUE(has_remark(*plan_of_text(disk_in_a_formula, {key + "=\"r - 4.2\""}),
                               key + " is not greater than 0 at camera.position = [4, 0, 1]"));
        EXPECT_FALSE(has_remark(*plan_of_text(disk_in_a_formula, {key + "=\"r - 3.9\""}), key));
    }
}

TEST(Remarks, AreMadeOnDisksInAFormulaWhoseMatterIsAtRest) {
    EXPECT_TRUE(has_remark(*plan_of_text(disk_in_a_formula, {}), "object.ring: the matter of the disk is at rest"));
    EXPECT_TRUE(plan_of_text(disk_in_a_formula, {"space={hamiltonian=\"schwarzschild\"}"})->remarks.empty());
}

TEST(Remarks, AreMadeOnDisksOutsideTheEscapeSphere) {
    const char* remark = "object.ring is not visible";
    const Override space = "space={hamiltonian=\"schwarzschild\"}";
    EXPECT_TRUE(has_remark(*plan_of_text(disk_in_a_formula, {space, "object.ring.inner=60", "object.ring.outer=70"}),
                           remark));
    EXPECT_FALSE(has_remark(*plan_of_text(disk_in_a_formula, {space, "object.ring.inner=40", "object.ring.outer=70"}),
                            remark));
}

TEST(Remarks, AreMadeOnConstantsAndHelpersThatNoFormulaUses) {
    const Overrides used{"space.constants.strength=1", "space.H=0.5*(px^2 + py^2 + pz^2 - strength)"};
    Overrides misspelt = used;
    misspelt.push_back("space.constants.strenght=2");
    misspelt.push_back("space.let.M=x");
    EXPECT_FALSE(has_remark(*plan_of_text(disk_in_a_formula, used), "has no effect"));
    EXPECT_TRUE(has_remark(*plan_of_text(disk_in_a_formula, misspelt),
                           "space.constants.strenght has no effect: no formula uses it; did you mean strength?"));
    EXPECT_TRUE(has_remark(*plan_of_text(disk_in_a_formula, misspelt), "space.let.M has no effect"));
}

TEST(Remarks, AreMadeOnAPixelErrorForListedRays) {
    const Overrides overrides{"integrator.max_pixel_error=0.5"};
    EXPECT_TRUE(has_remark(*plan_of_text(ball, overrides, {}, false), "integrator.max_pixel_error has no effect"));
    EXPECT_FALSE(has_remark(*plan_of_text(ball, overrides), "integrator.max_pixel_error has no effect"));
}

}  // namespace
}  // namespace kagero::test

// Remarks on what the user may not have meant: each is made where it belongs, and not where the scene means what it
// says.
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

bool remarks_on(const Plan& plan, const std::string& part) {
    return std::any_of(plan.remarks.begin(), plan.remarks.end(),
                       [&](const std::string& remark) { return remark.find(part) != std::string::npos; });
}

TEST(Remarks, AreMadeWhereTheyBelong) {
    struct {
        const char* part;
        Overrides said, meant;
    } const cases[] = {
        {"object.ball lies beyond", {"object.ball.center=[0,60,0]"}, {"object.ball.center=[0,50,0]"}},
        {"object.ball lies beyond",
         {"object.ball.center=[0,0,0]", "object.ball.radius=60"},
         {"object.ball.center=[0,40,0]", "object.ball.radius=60"}},
        {"camera.fov has no effect", {"camera.fov=50", "camera.type=orthographic"}, {"camera.fov=50"}},
        {"camera.fov has no effect", {"camera.fov=50", "camera.type=equirectangular"}, {"camera.type=equirectangular"}},
        {"integrator.tolerance has no effect",
         {"integrator.tolerance=1e-6", "integrator.method=rk4"},
         {"integrator.tolerance=1e-6"}},
    };
    for (const auto& [part, said, meant] : cases) {
        EXPECT_TRUE(remarks_on(*plan_of_text(ball, said), part)) << part;
        EXPECT_FALSE(remarks_on(*plan_of_text(ball, meant), part)) << part;
    }
}

TEST(Remarks, SayThatTheMatterOfADiskStandsStillInAFormula) {
    EXPECT_TRUE(remarks_on(*plan_of_text(disk_in_a_formula, {}), "object.ring: its matter stands still"));
    EXPECT_TRUE(plan_of_text(disk_in_a_formula, {"space={hamiltonian=\"schwarzschild\"}"})->remarks.empty());
}

TEST(Remarks, SayThatNothingOfADiskIsWithinTheEscapeSphere) {
    const char* lies_beyond = "object.ring lies beyond";
    const Override space = "space={hamiltonian=\"schwarzschild\"}";
    EXPECT_TRUE(remarks_on(*plan_of_text(disk_in_a_formula, {space, "object.ring.inner=60", "object.ring.outer=70"}),
                           lies_beyond));
    EXPECT_FALSE(remarks_on(*plan_of_text(disk_in_a_formula, {space, "object.ring.inner=40", "object.ring.outer=70"}),
                            lies_beyond));
}

TEST(Remarks, NameConstantsAndHelpersThatNoFormulaHas) {
    const Overrides used{"space.constants.strength=1", "space.H=0.5*(px^2 + py^2 + pz^2 - strength)"};
    Overrides misspelt = used;
    misspelt.push_back("space.constants.strenght=2"), misspelt.push_back("space.let.M=x");
    EXPECT_FALSE(remarks_on(*plan_of_text(disk_in_a_formula, used), "has no effect"));
    EXPECT_TRUE(remarks_on(*plan_of_text(disk_in_a_formula, misspelt),
                           "space.constants.strenght has no effect: no formula uses it; did you mean strength?"));
    EXPECT_TRUE(remarks_on(*plan_of_text(disk_in_a_formula, misspelt), "space.let.M has no effect"));
}

TEST(Remarks, SayThatSingleRaysFitNoPixels) {
    const Overrides fitted{"integrator.max_pixel_error=0.5"};
    EXPECT_TRUE(remarks_on(*plan_of_text(ball, fitted, {}, false), "integrator.max_pixel_error has no effect"));
    EXPECT_FALSE(remarks_on(*plan_of_text(ball, fitted), "integrator.max_pixel_error has no effect"));
}

}  // namespace
}  // namespace kagero::test

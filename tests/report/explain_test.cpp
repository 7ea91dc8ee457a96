// Tests of `kagero explain`. Each part of the program must be in exactly one of the lists `used` and `left_out`,
// depending on the scene.
#include "tests/support/hole_scene.h"

#include <nlohmann/json.hpp>

#include <algorithm>

namespace kagero::test {
namespace {

using nlohmann::json;

constexpr const char* mirage = R"([space]
hamiltonian = "mirage"
[camera]
position = [0, 0, 0]
look_at = [1, 0, 0]
up = [0, 0, 1]
[film]
size = [4, 4]
)";

class Explain : public HoleTest {
protected:
    json explained(const std::string& more = "") {
        const Outcome outcome = run("explain hole.toml --json " + more);
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        return json::parse(outcome.out);
    }
    /// Returns true if an entry of the list `used` begins with `part`.
    static bool uses(const json& plan, const std::string& part) {
        return std::any_of(plan["used"].begin(), plan["used"].end(),
                           [&](const json& item) { return item.get<std::string>().starts_with(part); });
    }
    /// Returns true if an entry of the list `left_out` begins with `part` and has a reason.
    static bool leaves_out(const json& plan, const std::string& part) {
        return std::any_of(plan["left_out"].begin(), plan["left_out"].end(), [&](const json& item) {
            return item["what"].get<std::string>().starts_with(part) && item["why"] != "";
        });
    }
};

TEST_F(Explain, ReportsAllKeys) {
    const json plan = explained();
    for (const char* key : {"kernel", "isa", "strategy", "precision", "lanes", "used", "left_out"})
        EXPECT_TRUE(plan.contains(key)) << key;
    EXPECT_EQ(plan["strategy"], "packet");
    EXPECT_GT(plan["lanes"], 1);
    const Outcome text = run("explain hole.toml");
    EXPECT_EQ(text.status, 0);
    for (const json& item : plan["left_out"])
        EXPECT_NE(text.out.find(item["what"].get<std::string>()), std::string::npos);
}

TEST_F(Explain, ListsEachPartAsUsedOrLeftOut) {
    struct {
        const char *part, *with, *without;
    } const parts[] = {
        {"integration by", "", "-D space.rg=0"},
        {"integration in the orbit plane", "", "-D integrator.symmetry=none"},
        {"time rescaling", "--integrator gauss8", "-D integrator.rescale=none"},
        {"step control", "--integrator dp54", ""},
        {"implicit equations", "--integrator gauss8", "--integrator rk4"},
        {"layer steps", "--layers color,steps", ""},
        {"scrambled Sobol", "--spp 4", ""},
        {"generation of camera rays in the kernel", "", "--spp 4"},
        {"refinement of events by correction steps", "", "-D integrator.hit=chord"},
        {"refill of lanes", "-D integrator.refill=on", ""},
        {"choice of method and step by a trial", "", "--step 0.3"},
    };
    for (const auto& [part, with, without] : parts) {
        SCOPED_TRACE(part);
        const json a = explained(with), b = explained(without);
        EXPECT_TRUE(uses(a, part) && !leaves_out(a, part));
        EXPECT_TRUE(!uses(b, part) && leaves_out(b, part));
    }
    EXPECT_TRUE(leaves_out(explained(), "Embree scene"));
    write("ball.toml",
          std::string(hole) + "[[object]]\nname = \"ball\"\nshape = \"sphere\"\ncenter = [1, 0, 0]\nradius = 0.2\n");
    const json ball = json::parse(run("explain ball.toml --json").out);
    EXPECT_TRUE(uses(ball, "Embree scene of 1 surface") && uses(ball, "clearance grid"));
}

// A space is stratified if H does not depend on a coordinate; for `mirage` this coordinate is y. Each step then updates
// y once, and not in every stage.
TEST_F(Explain, ListsTheStratifiedSpace) {
    write("mirage.toml", mirage);
    const auto explained_mirage = [&](const std::string& more) {
        return json::parse(run("explain mirage.toml --json " + more).out);
    };
    EXPECT_TRUE(uses(explained_mirage(""), "stratified space: one update per step of y"));
    EXPECT_TRUE(leaves_out(explained_mirage("-D integrator.symmetry=none"), "stratified space"));
    EXPECT_TRUE(leaves_out(explained_mirage("--integrator gauss8"), "stratified space"));
}

// The rescaled H of the mirage is separable, so that verlet is explicit.
TEST_F(Explain, ListsImplicitEquationsOnlyIfTheMethodHasThem) {
    write("mirage.toml", mirage);
    const auto implicit = [&](const std::string& more) {
        return uses(json::parse(run("explain mirage.toml --json --integrator " + more).out), "implicit equations");
    };
    EXPECT_TRUE(implicit("gauss8"));
    EXPECT_FALSE(implicit("verlet"));
    EXPECT_TRUE(implicit("verlet -D integrator.rescale=none"));
}

TEST_F(Explain, WritesNoPicture) {
    ASSERT_EQ(run("explain hole.toml").status, 0);
    EXPECT_FALSE(exists("hole.exr"));
    EXPECT_EQ(run("explain missing.toml").status, 2);
}

}  // namespace
}  // namespace kagero::test

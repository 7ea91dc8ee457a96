// Tests of the keys of a scene that describe a formula: use, refusal, overriding and printing. Helpers are the named
// expressions in the table [space.let].
#include "tests/formula/formula_scene.h"
#include "scene/print.h"

#include <gtest/gtest.h>

#include <sstream>

namespace kagero::test {
namespace {

// The method satoh4 alternates the flows of the two parts of H.
TEST(FormulaScene, ChecksAndUsesTheParts) {
    const std::string parts = straight_space + "parts = [\"0.5*(px^2 + py^2)\", \"0.5*(pz^2 - 1)\"]\n";
    EXPECT_EQ(refusal(parts, {"integrator.method=satoh4"}), "");
    EXPECT_EQ(traced(parts, {"integrator.method=satoh4"}, "packet", {{{0, 0, 0}, {1, 1, 0}}})[0].status,
              Status::escaped);
    // A method that does not use the parts must give the same rays with and without them.
    const std::string bounds = "length_scale = \"0.05 + 0.01*abs(z)\"\ndomain = \"8 - abs(x)\"\n";
    const auto rays = fan({-3, 0.5, 0.25});
    const auto with = traced(parts + bounds, {"integrator.step=1"}, "packet", rays),
               without = traced(straight_space + bounds, {"integrator.step=1"}, "packet", rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        EXPECT_EQ(with[i].steps, without[i].steps);
        EXPECT_EQ(with[i].q[0], without[i].q[0]);
    }
    EXPECT_NE(refusal(straight_space, {"integrator.method=satoh4"}).find("does not state the parts"),
              std::string::npos);
    EXPECT_NE(refusal(straight_space + "parts = [\"0.5*(px^2 + py^2)\", \"0.5*pz^2\"]\n").find("do not sum to space.H"),
              std::string::npos);
    EXPECT_NE(refusal(straight_space + "parts = [\"0.5*px^2\"]\n").find("two formulas"), std::string::npos);
}

// An override replaces the value of one key and keeps the order of helpers, because a helper can use the helpers above
// it. The names `color` and `texture`, which are keys of paints, are allowed as names of constants.
TEST(FormulaScene, KeepsTheOtherKeysAndTheirOrderWithOverrides) {
    const std::string text =
        "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - color*texture/(1 + r4))\"\n"
        "[space.constants]\ncolor = 2\ntexture = 3\n[space.let]\nr2 = \"x^2 + y^2 + z^2\"\nr4 = \"r2^2\"\n";
    const auto plan = plan_of_text(text + view_text, {"space.let.r2=x^2+y^2", "space.constants.color=5"});
    const FormulaDescription& formula = *plan->description().space.formula;
    EXPECT_EQ(formula.helpers[0], (std::pair<std::string, std::string>{"r2", "x^2+y^2"}));
    EXPECT_EQ(formula.constants[0], (std::pair<std::string, double>{"color", 5}));
    EXPECT_EQ(formula.constants[1], (std::pair<std::string, double>{"texture", 3}));
}

TEST(FormulaScene, RefusesIncompleteOrWrongKeys) {
    const std::pair<std::string, const char*> table[] = {
        {"[space]\nhamiltonian = \"formula\"\n", "space.H is missing"},
        {"[space]\nhamiltonian = \"formula\"\nH = 3\n", "it must be a string"},
        {"[space]\nhamiltonian = \"formula\"\nH = \"x^2\"\n", "a formula that contains px, py or pz"},
        {"[space]\nhamiltonian = \"formula\"\nH = \"px*foo\"\n", ":3:5: space.H, position 4: unknown name foo"},
        {straight_space + "domain = \"px\"\n", "it may depend only on x y z pt r theta phi rho"},
        {straight_space + "domain = \"L2\"\n", "depends on px"},
        {straight_space + "capture = \"1 - pphi\"\n", "depends on px"},
        {straight_space + "length_scale = \"pr\"\n", "depends on px"},
        {straight_space + "[integrator]\nrescale = \"ptheta\"\n", "depends on px"},
        {straight_space + "[space.constants]\nwhere = 1\n", "is the name of a function"},
        {straight_space + "[space.let]\nq = \"r + 1\"\nr = \"x\"\n", "'r' is used by a formula above"},
        {"[space]\nhamiltonian = \"formula\"\nH = \"r^2 + theta\"\n", "a formula that contains px, py or pz"},
        {straight_space + "domian = \"x\"\n", "did you mean \"domain\"?"},
        {straight_space + "rg = 1\n", "unknown key space.rg"},
        {straight_space + "[space.constants]\nx = 1\n", "is already defined in formulas"},
        {straight_space + "[space.constants]\nsin = 1\n", "is the name of a function"},
        {straight_space + "[space.let]\na = \"b\"\nb = \"1\"\n", "space.let.a, position 1: unknown name b"},
        {straight_space + "[space.let]\na = \"1\"\n[space.constants]\na = 1\n", "is already defined in formulas"},
        {straight_space + "[integrator]\nrescale = \"px\"\n", "it may depend only on x y z r theta phi rho"},
        {straight_space + "[integrator]\nrescale = \"q\"\n", "integrator.rescale, position 1: unknown name q"},
    };
    for (const auto& [text, message] : table)
        EXPECT_NE(refusal(text).find(message), std::string::npos) << text << refusal(text);
}

// The Cartesian form of each expression gives the same rays.
TEST(FormulaScene, AcceptsSphericalCoordinatesInEveryKey) {
    const auto space = [](const std::string& r2, const std::string& p2) {
        return "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(" + p2 + " - n^2)\"\nparts = [\"0.5*(" + p2 +
               ")\", \"-0.5*n^2\"]\ndomain = \"25 - " + r2 + "\"\ncapture = \"" + r2 +
               " - 0.04\"\nlength_scale = \"0.1 + 0.1*sqrt(" + r2 + ")\"\n[space.let]\nn = \"1 + exp(-" + r2 +
               ")\"\n[integrator]\nmethod = \"gauss8\"\nstep = 0.1\nrescale = \"1/(1 + " + r2 + ")\"\n";
    };
    const auto rays = fan({-3, 0.5, 0.25});
    const auto a = traced(space("(r^2)", "pr^2 + L2/r^2"), {}, "packet", rays),
               b = traced(space("(x^2 + y^2 + z^2)", "px^2 + py^2 + pz^2"), {}, "packet", rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        ASSERT_EQ(a[i].status, b[i].status) << i;
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(a[i].q[k], b[i].q[k], 1e-10) << i;
    }
}

TEST(FormulaScene, RefusesFormulasThatAreTooLarge) {
    std::ostringstream large;
    large << "[space]\nhamiltonian = \"formula\"\nH = \"px^2";
    for (int i = 0; i < 300; ++i) large << " + sin(" << i << "*x)";
    large << "\"\n";
    EXPECT_NE(refusal(large.str()).find("too large"), std::string::npos) << refusal(large.str());
}

// Each helper contains the previous helper twice. If helpers were expanded, the formulas would have 2^60 leaves, and
// the test would not end.
TEST(FormulaScene, ParsesEachHelperOnce) {
    const std::pair<const char*, const char*> forms[] = {
        {" + ", "1/z"}, {"*", "1/z"}, {" + ", "ptheta/theta"}, {"*", "ptheta"}};
    for (const auto& [helper, first] : forms) {
        std::ostringstream deep;
        deep << "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2) + "
                "1e-30*a60\"\n[integrator]\nrescale = \"z\"\n[space.let]\na0 = \"x + " << first << "\"\n";
        for (int i = 1; i <= 60; ++i)
            deep << 'a' << i << " = \"(a" << i - 1 << " + x)" << helper << 'a' << i - 1 << "\"\n";
        refusal(deep.str());  // the result is not tested: the scene is refused, because its numbers are too large
    }
}

TEST(FormulaScene, IsPrintedCompletely) {
    const std::string text = mirage_formula + view_text;
    const std::string printed = print_scene(plan_of_text(text, {"integrator.rescale=\"1/n\""})->description());
    EXPECT_EQ(print_scene(plan_of_text(printed, {})->description()), printed);
    EXPECT_NE(printed.find("n = \"0.85 - 0.3*z^3 + 0.03*cos(3*pi*x)\""), std::string::npos);
    EXPECT_NE(printed.find("rescale = \"1/n\""), std::string::npos);
}

}  // namespace
}  // namespace kagero::test

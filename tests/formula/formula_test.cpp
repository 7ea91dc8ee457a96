// Spaces whose Hamiltonian is written in the scene: the same rays as the built-in ones, and what can go wrong.
#include "scene/print.h"
#include "tests/support/plan_fixture.h"

#include "error.h"
#include "appearance/redshift.h"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

namespace kagero::test {
namespace {

const std::string rest = "\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\n[film]\nsize = [4, 4]\n";

struct Pair {
    const char *name, *built_in, *formula;
    double origin[3];
    const char* escape_radius = "9";  ///< less in media that keep rays for thousands of steps
};

/// H as in the header of each Hamiltonian that can be written so: a formula knows no far side (wormhole), no surface on
/// which steps end (luneburg) and no seed (shimmer).
const Pair pairs[] = {
    {"flat", "[space]\nhamiltonian = \"flat\"\n", "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - 1)\"\n", {-3, 0.5, 0.25}},
    {"schwarzschild", "[space]\nhamiltonian = \"schwarzschild\"\nrg = 0.5\n",
     "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - pt^2) - 0.5*(rg/r)*u^2\"\n"
     "capture = \"r - rg\"\n[space.constants]\nrg = 0.5\npt = 1\n[space.let]\nr = \"sqrt(x^2 + y^2 + z^2)\"\nu = \"pt + (x*px + y*py + z*pz)/r\"\n",
     {-7, 0.5, 0.25}},
    {"mirage", "[space]\nhamiltonian = \"mirage\"\n",
     "[space]\nhamiltonian = \"formula\"\nH = \"0.5*n*(px^2 + py^2 + pz^2)\"\nH0 = 0.5\ndomain = \"n - 0.05\"\n"
     "length_scale = \"0.2*max(n, 0.05)/sqrt((0.09*pi)^2 + (0.9*z^2)^2)\"\n"
     "[space.let]\nn = \"0.85 - 0.3*z^3 + 0.03*cos(3*pi*x)\"\n", {0, 0, 0}},
    {"fisheye", "[space]\nhamiltonian = \"fisheye\"\nn0 = 2\nradius = 1\n",
     "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - (2/(1 + x^2 + y^2 + z^2))^2)\"\n", {-1, 0.1, 0}, "1.5"},
    {"fiber", "[space]\nhamiltonian = \"fiber\"\nn0 = 1.5\nalpha = 0.3\n",
     "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - (1.5^2)*(1 - (0.3^2)*(x^2 + y^2)))\"\n", {0.3, 0.1, 0}, "1.5"},
    {"gradient", "[space]\nhamiltonian = \"gradient\"\n",
     "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - (1 - 0.1*z))\"\n", {-3, 0.5, 0.25}},
    {"layer", "[space]\nhamiltonian = \"layer\"\n",
     "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - (0.5*(1.5^2 + 1) + 0.5*(1 - 1.5^2)*tanh(z/0.1)))\"\n"
     "length_scale = \"0.1*max(0.1, abs(z))\"\n", {-3, 0.5, -1}},
    {"duct", "[space]\nhamiltonian = \"duct\"\n",
     "[space]\nhamiltonian = \"formula\"\nH = \"0.5*n*(px^2 + py^2 + pz^2)\"\nH0 = 0.5\n"
     "[space.let]\nn = \"0.85 + 0.3*z^2*abs(z) + 0.03*cos(3*pi*x)\"\n", {0, 0, 0}},
    {"kerr", "[space]\nhamiltonian = \"kerr\"\nmass = 0.25\nspin = 0.6\n",
     "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - pt^2) - 0.5*f*(pt + lx*px + ly*py + z/r*pz)^2\"\n"
     "[space.constants]\npt = 1\nM = 0.25\na = 0.15\n[space.let]\ns = \"x^2 + y^2 + z^2 - a^2\"\nr = \"sqrt(0.5*(s + sqrt(s^2 + 4*a^2*z^2)))\"\n"
     "f = \"2*M*r^3/(r^4 + a^2*z^2)\"\nlx = \"(r*x - a*y)/(r^2 + a^2)\"\nly = \"(r*y + a*x)/(r^2 + a^2)\"\n", {-7, 0.5, 0.25}},
};

bool is_built(const std::string& name) {
    const Catalogue c = catalogue("auto");
    for (std::uint32_t i = 0; i < c.hamiltonian_count; ++i)
        if (name == c.hamiltonians[i].name) return true;
    return false;
}

std::vector<RayInput> fan(const double (&origin)[3]) {
    std::vector<RayInput> rays;
    for (int i = 0; i < 37; ++i)
        rays.push_back({{origin[0], origin[1], origin[2]}, {1, 0.04 * i - 0.9, 0.3 - 0.01 * i}});
    return rays;
}

std::vector<RayEnd> traced(const std::string& text, const Overrides& overrides, const std::string& strategy,
                           const std::vector<RayInput>& rays, const std::string& isa = "auto") {
    Options options = with_strategy(strategy);
    options.isa = isa;
    options.energy_error = true;
    const auto plan = plan_of_text(text + rest, overrides, options, false);
    std::vector<RayEnd> ends;
    trace(*plan, start_rays(*plan, rays), ends);
    return ends;
}

std::string refusal(const std::string& text, const Overrides& overrides = {}) {
    try {
        plan_of_text(text + rest, overrides, with_strategy("packet"));
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

void expect_close(const double (&a)[3], const double (&b)[3], double tolerance) {
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(a[k], b[k], tolerance * (1 + std::abs(a[k])));
}

// Both take the same steps on the same H: what differs is the order of roundings, some hundred of them.
class FormulaOn : public testing::TestWithParam<std::string> {};

TEST_P(FormulaOn, HasTheRaysOfTheBuiltIn) {
    for (const Pair& pair : pairs) {
        if (!is_built(pair.name)) continue;
        for (const char* method : {"verlet", "gauss8", "gauss4", "rk4", "suzuki4-nine"}) {
            const Overrides same{"integrator.rescale=none", std::string("integrator.method=") + method,
                                 "integrator.step=0.05", std::string("integrator.escape_radius=") + pair.escape_radius};
            for (const char* strategy : {"packet", "scalar"}) {
                SCOPED_TRACE(std::string(pair.name) + ", " + method + ", " + strategy);
                const auto rays = fan(pair.origin);
                const auto a = traced(pair.built_in, same, strategy, rays, GetParam());
                const auto b = traced(pair.formula, same, strategy, rays, GetParam());
                std::size_t compared = 0;
                for (std::size_t i = 0; i < a.size(); ++i) {
                    if (a[i].status == Status::captured) continue;  // earlier than at the horizon
                    ASSERT_EQ(a[i].status, b[i].status) << i;
                    if (a[i].status != Status::escaped) continue;
                    if (a[i].steps > 450) continue;  // a ray that nearly stays makes much more of a rounding
                    const double tolerance = 1e-12;
                    expect_close(a[i].q, b[i].q, tolerance), expect_close(a[i].p, b[i].p, tolerance),
                        expect_close(a[i].v, b[i].v, tolerance);
                    // Straight rays are known to be straight, and take one long step.
                    const bool same_steps = pair.name == std::string("flat") || a[i].steps == b[i].steps;
                    EXPECT_TRUE(same_steps) << i;
                    ++compared;
                }
                EXPECT_GE(compared, 10u);
            }
        }
    }
}

const std::string index = "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - 1)\"\n";

// An exponential beyond the range of numbers is one over 0 of its reciprocal, and no reason to forget a bound.
TEST_P(FormulaOn, BoundsHoldWhereExponentialsOverflow) {
    const std::vector<RayInput> rays{{{3, 0, 0}, {1, 0, 0}}};
    for (const char* strategy : {"packet", "scalar"}) {
        const auto steps = [&](const char* bound) {
            return traced(index + bound, {"integrator.step=1"}, strategy, rays, GetParam())[0].steps;
        };
        EXPECT_EQ(steps("length_scale = \"0.25 + 1/(1 + exp(1000*x))\"\n"), steps("length_scale = \"0.25\"\n"));
        EXPECT_EQ(steps("length_scale = \"min(0.25, 1/(y^2 + z^2))\"\n"), steps("length_scale = \"0.25\"\n"));
        const RayEnd outside =
            traced(index + "domain = \"1/(1 + exp(1000*(x - 2))) - 0.5\"\n", {}, strategy, rays, GetParam())[0];
        EXPECT_EQ(outside.status, Status::escaped);
        EXPECT_EQ(outside.steps, 0u);
        EXPECT_EQ(outside.q[0], 3);
    }
}

INSTANTIATE_TEST_SUITE_P(EveryIsa, FormulaOn, testing::ValuesIn(supported_isas()),
                         [](const auto& isa) { return isa.param; });

// Light in a spacetime is seen by the same observers, at the same frequency, whether its H is built in or written.
TEST(FormulaSpace, SpacetimesHaveRestFrames) {
    for (const Pair& pair : pairs) {
        if (!is_built(pair.name) || (std::string(pair.name) != "kerr" && std::string(pair.name) != "schwarzschild"))
            continue;
        for (const std::string observer : {"static", "coordinate"}) {
            const std::string camera = "[camera]\nposition = [-3, 0.5, 0.25]\nlook_at = [0, 0, 0]\nobserver = \"" +
                                       observer + "\"\n[film]\nsize = [9, 7]\n";
            const auto written = plan_of_text(pair.formula + camera, {}),
                       built = plan_of_text(pair.built_in + camera, {});
            for (std::uint32_t y = 0; y < 7; ++y)
                for (std::uint32_t x = 0; x < 9; ++x) {
                    const CameraRay a = camera_ray(*written, x + 0.5, y + 0.5),
                                    b = camera_ray(*built, x + 0.5, y + 0.5);
                    // A built-in's ray at rest in the slicing keeps its p_t, a formula's has that of the formula.
                    const double scale = a.start.pt / b.start.pt;
                    for (int k = 0; k < 3; ++k)
                        EXPECT_NEAR(a.start.p[k], scale * b.start.p[k], 1e-12) << pair.name << ' ' << observer;
                    EXPECT_NEAR(a.frequency, scale * b.frequency, 1e-12);
                    RayEnd end{}, same{};
                    end.status = same.status = Status::escaped, end.pt = a.start.pt, same.pt = b.start.pt;
                    EXPECT_NEAR(redshift_of(*written, {&end, &a}), redshift_of(*built, {&same, &b}), 1e-12);
                }
        }
        EXPECT_NE(refusal(pair.formula, {"camera.observer=zamo"}).find("here can be: static, coordinate"),
                  std::string::npos);
    }
}

// A formula quadratic in p gives the camera a map from directions to momenta: it is that of the built-in, in every
// direction.
TEST(FormulaSpace, CamerasOfQuadraticFormsNeedNoSolve) {
    const std::string form =
        "[space]\nhamiltonian = \"formula\"\nH = \"px^2 + 0.5*(py^2 + pz^2) + 0.3*px*py + 0.2*px*x - 0.1*pz\"\nH0 = "
        "0.5\n";
    const std::string camera =
        "[camera]\nposition = [-3, 0.5, 0.25]\nlook_at = [0, 0, 0]\nobserver = \"coordinate\"\n[film]\nsize = [9, 7]\n";
    const auto plan = plan_of_text(form + camera, {});
    EXPECT_FALSE(plan->view.each_direction);
    for (std::uint32_t y = 0; y < 7; ++y)
        for (std::uint32_t x = 0; x < 9; ++x) {
            const RayStart seen = pixel_ray(*plan, x, y);
            Double3 d;
            for (std::size_t k = 0; k < 3; ++k)
                d[k] = plan->view.camera.corner[k] + (x + 0.5) * plan->view.camera.right[k] +
                       (y + 0.5) * plan->view.camera.down[k];
            const RayStart solved = plan->scene->space.start(plan->view.camera.position, d);
            expect_close(seen.p, solved.p, 1e-12);
        }
    const auto quartic =
        plan_of_text("[space]\nhamiltonian = \"formula\"\nH = \"(px^2 + 2*py^2 + pz^2)^2 - 1\"\n" + rest, {});
    EXPECT_TRUE(quartic->view.each_direction);
}

TEST(FormulaSpace, IsTheSameInUnitsOfAnySize) {
    const auto end_of = [](const std::string& size) {
        const auto plan = plan_of_text(
            "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2) - 0.5*(1.5 - (x^2 + y^2)/L^2)\"\n"
            "constants = {L = " +
                size + "}\n[integrator]\nmethod = \"srkn6\"\nstep = 0.01\nescape_radius = 3e" + size.substr(2) +
                "\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\n[film]\nsize = [8, 8]\n",
            {}, with_strategy("scalar"), false);
        const double unit = std::stod(size);
        plan->run.step *= unit;
        std::vector<RayEnd> ends;
        trace(*plan, start_rays(*plan, {{{0.25 * unit, 0, 0}, {0.1, 0.2, 1}}}), ends);
        EXPECT_EQ(ends[0].status, Status::escaped);
        return std::array{ends[0].q[0] / unit, ends[0].q[1] / unit, ends[0].v[0]};
    };
    const auto small = end_of("1e0"), large = end_of("1e11");
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(large[k], small[k], 1e-12);
}

TEST(FormulaSpace, RescalesAndSeparates) {
    if (!is_built("mirage")) GTEST_SKIP();
    const Pair& mirage = pairs[2];
    const auto rays = fan(mirage.origin);
    const Overrides same{"integrator.method=srkn6", "integrator.step=0.1", "integrator.escape_radius=9"};
    Overrides stated = same;
    stated.push_back("integrator.rescale=\"1/n\"");
    for (const char* strategy : {"packet", "scalar"}) {
        const auto a = traced(mirage.built_in, same, strategy, rays),
                   b = traced(mirage.formula, stated, strategy, rays);
        for (std::size_t i = 0; i < a.size(); ++i) {
            ASSERT_EQ(a[i].status, b[i].status);
            expect_close(a[i].q, b[i].q, 1e-12);
            EXPECT_NEAR(a[i].parameter, b[i].parameter, 1e-12 * (1 + a[i].parameter));
        }
    }
    EXPECT_NE(refusal(mirage.formula, same).find("not of the form |p|^2/2 + V(q)"), std::string::npos);
}

TEST(FormulaSpace, PacketsAndSingleRaysAgree) {
    const std::string strange =
        "[space]\nhamiltonian = \"formula\"\nH = \"0.5*u + 0.1*u^2*tanh(1 + sin(x)*exp(-y^2)) + 0.1*atan2(z, "
        "3)*px*max(x, y)\"\nH0 = 0.5\n"
        "[space.let]\nu = \"px^2 + 1.5*py^2 + pz^2\"\n";
    const auto rays = fan({-2, 0.1, 0.2});
    for (const char* method : {"verlet", "gauss8", "dp54"}) {
        const Overrides with{std::string("integrator.method=") + method, "integrator.escape_radius=4",
                             "integrator.step=0.05"};
        const auto a = traced(strange, with, "packet", rays), b = traced(strange, with, "scalar", rays);
        for (std::size_t i = 0; i < a.size(); ++i) {
            ASSERT_EQ(a[i].status, b[i].status) << method << ' ' << i << ' ' << static_cast<int>(a[i].failure);
            EXPECT_EQ(a[i].status, Status::escaped);
            expect_close(a[i].q, b[i].q, 1e-9), expect_close(a[i].p, b[i].p, 1e-9);
        }
    }
}

TEST(FormulaSpace, StartsAlongTheDirection) {
    const char* const energies[] = {"0.5*(px^2 + 2*py^2 + pz^2 + px*py)",
                                    "0.25*(px^4 + py^4 + pz^4) + 0.1*px*py",
                                    "sqrt(px^2 + py^2 + 3*pz^2)",
                                    "0.5*((px - y)^2 + (py + x)^2 + pz^2)",
                                    "exp(px^2 + py^2 + pz^2) - 1",
                                    "px^4 + py^4 + pz^4",
                                    "1e-8*(px^6 + py^6 + pz^6)",
                                    "2 - px^4 - 2*py^4 - pz^4",
                                    "(px - 1000)^4 + (py + 500)^4 + (pz - 3000)^4"};
    for (const std::string energy : energies) {
        const auto plan = plan_of_text("[space]\nhamiltonian = \"formula\"\nH0 = 0.5\nH = \"" + energy + "\"\n" + rest,
                                       {}, {}, false);
        const std::vector<RayInput> rays{{{0.3, 0.2, 0.1}, {1, 2, 3}},
                                         {{0.3, 0.2, 0.1}, {-2, 0.1, 0.4}},
                                         {{0, 0, 0}, {0.1, -1, 0.2}},
                                         {{0, 0, 0}, {0, 1, 1e-3}}};
        std::vector<RayEnd> ends;
        const auto starts = start_rays(*plan, rays);
        const auto points = trace_paths(*plan, starts, ends);
        for (const PathPoint& point : points) {
            if (point.step != 0) continue;
            const auto& d = rays[point.ray].direction;
            const double size = std::hypot(d[0], d[1], d[2]);
            for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(point.v[k], d[k] / size, 1e-10) << energy;
            EXPECT_NEAR(point.energy, 0.5, 1e-10) << energy;
        }
        for (const RayStart& start : starts) EXPECT_EQ(start.failure, Failure::none) << energy;
    }
    const auto none =
        plan_of_text("[space]\nhamiltonian = \"formula\"\nH0 = -1\nH = \"px^2 + py^2 + pz^2\"\n" + rest, {}, {}, false);
    EXPECT_EQ(start_rays(*none, {{{0, 0, 0}, {1, 0, 0}}})[0].failure, Failure::no_momentum);
    const auto singular =
        plan_of_text("[space]\nhamiltonian = \"formula\"\nH = \"(px^2 + py^2 + pz^2)/x - 1\"\n" + rest, {}, {}, false);
    EXPECT_EQ(start_rays(*singular, {{{0, 0, 0}, {1, 0, 0}}})[0].failure, Failure::singular_start);
}

TEST(FormulaSpace, EndsWhereTheSceneSays) {
    const std::vector<RayInput> rays{{{0, 0, 0}, {1, 0, 0}}};
    const auto edge = traced(index + "domain = \"2 - x\"\n", {}, "packet", rays)[0];
    EXPECT_EQ(edge.status, Status::escaped);
    EXPECT_NEAR(edge.q[0], 2, 1e-12);
    EXPECT_EQ(traced(index + "capture = \"2 - x\"\n", {}, "packet", rays)[0].status, Status::captured);
    const auto free = traced(index, {"integrator.step=1"}, "packet", rays)[0],
               bound = traced(index + "length_scale = \"0.25\"\n", {"integrator.step=1"}, "packet", rays)[0];
    EXPECT_EQ(bound.steps, 4 * free.steps);
}

TEST(FormulaSpace, PartsAreCheckedAndUsed) {
    const std::string parts = index + "parts = [\"0.5*(px^2 + py^2)\", \"0.5*(pz^2 - 1)\"]\n";
    EXPECT_EQ(refusal(parts, {"integrator.method=satoh4"}), "");
    EXPECT_EQ(traced(parts, {"integrator.method=satoh4"}, "packet", {{{0, 0, 0}, {1, 1, 0}}})[0].status,
              Status::escaped);
    // Parts leave the rest of the scene's formulas alone.
    const std::string scale = "length_scale = \"0.05 + 0.01*abs(z)\"\ndomain = \"8 - abs(x)\"\n";
    const auto rays = fan({-3, 0.5, 0.25});
    const auto with = traced(parts + scale, {"integrator.step=1"}, "packet", rays),
               without = traced(index + scale, {"integrator.step=1"}, "packet", rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        EXPECT_EQ(with[i].steps, without[i].steps);
        EXPECT_EQ(with[i].q[0], without[i].q[0]);
    }
    EXPECT_NE(refusal(index, {"integrator.method=satoh4"}).find("states no parts"), std::string::npos);
    EXPECT_NE(refusal(index + "parts = [\"0.5*(px^2 + py^2)\", \"0.5*pz^2\"]\n").find("do not sum to space.H"),
              std::string::npos);
    EXPECT_NE(refusal(index + "parts = [\"0.5*px^2\"]\n").find("two formulas"), std::string::npos);
}

// A value from the command line takes the place of the one before: helpers use those above them, and names that paints
// have elsewhere are names like others.
TEST(FormulaSpace, OverridesLeaveTheRest) {
    const std::string text =
        "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - color*texture/(1 + r4))\"\n"
        "[space.constants]\ncolor = 2\ntexture = 3\n[space.let]\nr2 = \"x^2 + y^2 + z^2\"\nr4 = \"r2^2\"\n";
    const auto plan = plan_of_text(text + rest, {"space.let.r2=x^2+y^2", "space.constants.color=5"});
    const FormulaDescription& formula = *plan->description().space.formula;
    EXPECT_EQ(formula.helpers[0], (std::pair<std::string, std::string>{"r2", "x^2+y^2"}));
    EXPECT_EQ(formula.constants[0], (std::pair<std::string, double>{"color", 5}));
    EXPECT_EQ(formula.constants[1], (std::pair<std::string, double>{"texture", 3}));
}

TEST(FormulaSpace, RefusesWhatItCannotUse) {
    const std::pair<std::string, const char*> table[] = {
        {"[space]\nhamiltonian = \"formula\"\n", "space.H is missing"},
        {"[space]\nhamiltonian = \"formula\"\nH = 3\n", "expected a string"},
        {"[space]\nhamiltonian = \"formula\"\nH = \"x^2\"\n", "in which px, py or pz occurs"},
        {"[space]\nhamiltonian = \"formula\"\nH = \"px*foo\"\n", ":3:5: space.H, position 4: unknown name foo"},
        {index + "domain = \"px\"\n", "it may depend on x y z pt alone"},
        {index + "domian = \"x\"\n", "did you mean \"domain\"?"},
        {index + "rg = 1\n", "unknown key space.rg"},
        {index + "[space.constants]\nx = 1\n", "has a meaning in formulas already"},
        {index + "[space.constants]\nsin = 1\n", "is a function"},
        {index + "[space.let]\na = \"b\"\nb = \"1\"\n", "space.let.a, position 1: unknown name b"},
        {index + "[space.let]\na = \"1\"\n[space.constants]\na = 1\n", "has a meaning in formulas already"},
        {index + "[integrator]\nrescale = \"px\"\n", "it may depend on x y z and r alone"},
        {index + "[integrator]\nrescale = \"q\"\n", "integrator.rescale, position 1: unknown name q"},
    };
    for (const auto& [text, says] : table)
        EXPECT_NE(refusal(text).find(says), std::string::npos) << text << refusal(text);
}

TEST(FormulaSpace, TooLargeOnesAreRefusedAtOnce) {
    std::ostringstream large;
    large << "[space]\nhamiltonian = \"formula\"\nH = \"px^2";
    for (int i = 0; i < 300; ++i) large << " + sin(" << i << "*x)";
    large << "\"\n";
    EXPECT_NE(refusal(large.str()).find("too large"), std::string::npos) << refusal(large.str());
}

// As trees these formulas have 2^60 leaves. A shared helper is read, and printed, once; otherwise this test would not
// end.
TEST(FormulaSpace, HelpersOfHelpersAreReadOnce) {
    for (const char* helper : {" + ", "*"}) {
        std::ostringstream deep;
        deep << "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2) + "
                "1e-30*a60\"\n[integrator]\nrescale = \"z\"\n[space.let]\na0 = \"x + 1/z\"\n";
        for (int i = 1; i <= 60; ++i)
            deep << 'a' << i << " = \"(a" << i - 1 << " + x)" << helper << 'a' << i - 1 << "\"\n";
        refusal(deep.str());  // no ray starts, because the numbers are too large; the message does not matter here
    }
}

TEST(FormulaSpace, IsPrintedWhole) {
    const std::string text = pairs[2].formula + rest;
    const std::string once = print_scene(plan_of_text(text, {"integrator.rescale=\"1/n\""})->description());
    EXPECT_EQ(print_scene(plan_of_text(once, {})->description()), once);
    EXPECT_NE(once.find("n = \"0.85 - 0.3*z^3 + 0.03*cos(3*pi*x)\""), std::string::npos);
    EXPECT_NE(once.find("rescale = \"1/n\""), std::string::npos);
}

}  // namespace
}  // namespace kagero::test

// Sweeps of the constants of formulas: the lanes of a packet have different constants. The results are those of one
// trace per set, and those of built-in spaces.
#include "error.h"
#include "tests/sweep/sweeper.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace kagero::test {
namespace {

std::string formula_scene(const std::string& keys, const std::string& constants, const std::string& helpers = "") {
    return "[space]\nhamiltonian = \"formula\"\n" + keys + "[space.constants]\n" + constants + "[space.let]\n" +
           helpers + "[integrator]\nescape_radius = 12\n";
}

std::vector<double> range(double first, double last, int count) {
    std::vector<double> values;
    for (int i = 0; i < count; ++i) values.push_back(first + (last - first) * i / (count - 1));
    return values;
}

// A lens, the same with a kink, a charged hole in the notation of textbooks, and a medium with all optional formulas.
TEST(FormulaSweep, EqualsSeparateTraces) {
    struct Case {
        std::string scene;
        bool is_spacetime;
        std::vector<SweptKey> keys;
    };
    const Case cases[] = {
        {formula_scene("H = \"(px^2 + py^2 + pz^2 - (1 + a*exp(-r^2/w))^2)/2\"\n", "a = 0.2\nw = 2\n"),
         false,
         {{"space.constants.a", range(0, 0.5, 37)}, {"space.constants.w", range(3, 1, 37)}}},
        {formula_scene("H = \"(px^2 + py^2 + pz^2 - n^2)/2\"\n", "a = 0.2\nb = 4\n", "n = \"1 + a*max(0, 1 - r/b)\"\n"),
         false,
         {{"space.constants.b", range(2, 5, 20)}}},
        {formula_scene("H = \"(px^2 + py^2 + pz^2 - pt^2 - (2*m/r - k^2/r^2)*(pt + pr)^2)/2\"\n"
                       "capture = \"r - m - sqrt(m^2 - k^2)\"\nlength_scale = \"0.25*r\"\n",
                       "pt = 1\nm = 0.5\nk = 0.3\n"),
         true,
         {{"space.constants.m", range(0.3, 0.6, 25)}, {"space.constants.k", range(0, 0.29, 25)}}},
        {formula_scene("H = \"(pr^2 + (ptheta^2 + pphi^2/sin(theta)^2)/r^2 - n^2)/2\"\nH0 = 0.1\n"
                       "domain = \"edge - z\"\nlength_scale = \"scale/4\"\n",
                       "g = 0.1\nedge = 3\nscale = 2\n", "n = \"1.2 + g*z\"\n"),
         false,
         {{"space.constants.edge", range(1, 4, 18)},
          {"space.constants.scale", range(1, 3, 18)},
          {"space.constants.g", range(-0.1, 0.1, 18)}}},
    };
    for (const Case& c : cases) {
        SCOPED_TRACE(c.scene);
        const Sweeper sweeper{c.scene, all_columns(c.is_spacetime)};
        const SweepResult result = sweeper.sweep(c.keys, passing_rays());
        EXPECT_EQ(result.reason_against_packets, "");
        expect_same_as_separate(sweeper, c.keys, passing_rays(), 1e-7, result);
    }
}

// The starts of rays from the rest frame of an observer depend on the metric of each set.
TEST(FormulaSweep, StartsRaysOfObserversInEachSet) {
    Options options = all_columns(true);
    options.observer = ObserverKind::static_;
    const Sweeper sweeper{formula_scene("H = \"(px^2 + py^2 + pz^2 - pt^2 - 2*m/r*(pt + pr)^2)/2\"\ncapture = \"r - "
                                        "2*m\"\n",
                                        "pt = 1\nm = 0.5\n"),
                          options};
    const std::vector<SweptKey> mass{{"space.constants.m", range(0.2, 0.6, 20)}};
    const SweepResult result = sweeper.sweep(mass, passing_rays());
    EXPECT_EQ(result.reason_against_packets, "");
    expect_same_as_separate(sweeper, mass, passing_rays(), 1e-7, result);
    const Sweeper hole{"[space]\nhamiltonian = \"schwarzschild\"\n[integrator]\nescape_radius = 12\n", options};
    std::vector<double> rg;
    for (const double m : mass[0].values) rg.push_back(2 * m);
    const SweepResult of_hole = hole.sweep({{"space.rg", rg}}, passing_rays());
    for (std::size_t i = 0; i < result.ends.size(); ++i) {
        ASSERT_EQ(int(result.ends[i].status), int(of_hole.ends[i].status)) << i;
        if (result.ends[i].status != Status::escaped) continue;
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(result.ends[i].q[k], of_hole.ends[i].q[k], 1e-6) << i;
    }
}

// Rays in N² = n0² − g z are parabolas: dq/dλ = p with |p| = N at the start, and dp_z/dλ = −g/2.
TEST(FormulaSweep, FollowsTheParabolasOfEachGradient) {
    const Sweeper sweeper{formula_scene("H = \"(px^2 + py^2 + pz^2 - (n0^2 - g*z))/2\"\ndomain = \"4 - x\"\n",
                                        "n0 = 1.5\ng = 0.1\n"),
                          all_columns(false)};
    const std::vector<SweptKey> keys{{"space.constants.g", range(-0.2, 0.2, 41)},
                                     {"space.constants.n0", range(1.2, 1.6, 41)}};
    const SweepResult result = sweeper.sweep(keys, {{{-4, 0, 0.5}, {1, 0, 0.25}}});
    EXPECT_EQ(result.reason_against_packets, "");
    for (std::size_t set = 0; set < 41; ++set) {
        const double g = keys[0].values[set], n0 = keys[1].values[set];
        const double speed = std::sqrt((n0 * n0 - 0.5 * g) / (1 + 0.0625)), lambda = 8 / speed;
        EXPECT_NEAR(result.ends[set].q[0], 4, 1e-9);
        EXPECT_NEAR(result.ends[set].q[2], 0.5 + 0.25 * speed * lambda - 0.25 * g * lambda * lambda, 1e-8) << set;
        EXPECT_NEAR(result.ends[set].parameter, lambda, 1e-8) << set;
    }
}

TEST(FormulaSweep, StatesWhyEachSetHasItsOwnPlan) {
    struct Case {
        std::string scene, key, reason;
    };
    const std::string lens = "H = \"(px^2 + py^2 + pz^2 - (1 + a*exp(-r^2))^2)/2\"\n";
    const Case cases[] = {
        {formula_scene("H = \"(px^2 + py^2 + pz^2 - pt^2 - a*(pt + pr)^2/r)/2\"\n", "a = 0.2\npt = 1\n"),
         "space.constants.pt", "not a constant"},
        {formula_scene(lens, "a = 0.2\n"), "integrator.escape_radius", "not a constant"},
        {formula_scene("H = \"(px^2 + py^2 + pz^2 - (1 + 0.1*z^a)^2)/2\"\n", "a = 2\n"), "space.constants.a",
         "exponent"},
        {formula_scene(lens + "parts = [\"(px^2 + py^2 + pz^2)/2\", \"-(1 + a*exp(-r^2))^2/2\"]\n", "a = 0.2\n"),
         "space.constants.a", "space.parts"},
        {formula_scene(lens, "a = 0.2\n") + "rescale = \"1 + r\"\n", "space.constants.a", "integrator.rescale"},
        {formula_scene(lens, "a = 0.2\n") + "method = \"gauss8\"\n", "space.constants.a", "do not adapt"},
    };
    for (const Case& c : cases) {
        SCOPED_TRACE(c.reason);
        const Sweeper sweeper{c.scene, all_columns(false)};
        const std::vector<SweptKey> keys{{c.key, {2, 3, 4}}};
        const SweepResult result = sweeper.sweep(keys, passing_rays());
        EXPECT_NE(result.reason_against_packets.find(c.reason), std::string::npos) << result.reason_against_packets;
        expect_same_as_separate(sweeper, keys, passing_rays(), 1e-12, result);
    }
}

TEST(FormulaSweep, RefusesSetsThatAPlanOfTheirOwnWouldRefuse) {
    const std::string scene = formula_scene(
        "H = \"(px^2 + py^2 + pz^2 - (1 + (1/a)*exp(-r^2))^2)/2\"\nlength_scale = \"l\"\n", "a = 2\nl = 1\n");
    const Sweeper sweeper{scene, all_columns(false)};
    const auto message_of = [&](const std::vector<SweptKey>& keys) -> std::string {
        try {
            sweeper.sweep(keys, passing_rays());
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    };
    EXPECT_EQ(message_of({{"space.constants.a", {1, 2}}}), "");
    const double nan = std::nan("");
    EXPECT_NE(message_of({{"space.constants.a", {1, 0}}}).find("set 1 of the sweep, with space.constants.a = 0"),
              std::string::npos);
    EXPECT_NE(message_of({{"space.constants.l", {1, -1}}}).find("space.length_scale is -1"), std::string::npos);
    EXPECT_NE(message_of({{"space.constants.a", {1, nan}}}).find("value 1 of space.constants.a"), std::string::npos);
}

}  // namespace
}  // namespace kagero::test

// Sweeps give the same results as one trace per set: for every built-in space and each of its parameters, with
// surfaces, near spinning holes, and for keys that are not parameters of the space.
#include "tests/sweep/sweeper.h"

#include <gtest/gtest.h>

#include <atomic>
#include <limits>
#include <numbers>

namespace kagero::test {
namespace {

/// Returns legal values of a parameter: its least value if it is legal, and values around the default.
std::vector<double> values_of(const ParameterInfo& parameter) {
    std::vector<double> values;
    if (std::isfinite(parameter.least) && !parameter.least_open) values.push_back(parameter.least);
    for (int i = 0; i < 20; ++i) {
        const double factor = 0.6 + 0.04 * i,
                     value = parameter.default_value == 0 ? 0.01 * i : parameter.default_value * factor;
        const double legal = parameter.unit == Unit::whole_number ? 1.0 + i : value;
        values.push_back(std::clamp(legal, parameter.least_open ? legal : parameter.least, parameter.greatest));
    }
    return values;
}

/// Sweeps every parameter of a space and compares the ends with those of separate traces. Returns the number of
/// parameters whose sets shared packets.
int expect_sweeps_of(const HamiltonianInfo& space, const std::string& isa) {
    Options options = all_columns(space.spacetime);
    options.isa = isa;
    const Sweeper sweeper{std::string("[space]\nhamiltonian = \"") + space.name +
                              "\"\n[integrator]\nescape_radius = 12\n",
                          options};
    int in_packets = 0;
    for (std::uint32_t i = 0; i < space.parameter_count; ++i) {
        const ParameterInfo& parameter = space.parameters[i];
        SCOPED_TRACE(isa + ", " + space.name + ": " + parameter.name);
        const std::vector<SweptKey> keys{{std::string("space.") + parameter.name, values_of(parameter)}};
        const SweepResult result = sweeper.sweep(keys, passing_rays());
        EXPECT_EQ(result.reason_against_packets.empty(), !space.discontinuous) << result.reason_against_packets;
        EXPECT_FALSE(result.interrupted);
        expect_same_as_separate(sweeper, keys, passing_rays(), 1e-6, result);
        in_packets += result.reason_against_packets.empty();
    }
    return in_packets;
}

TEST(Sweep, OfEveryParameterOfEverySpaceEqualsSeparateTraces) {
    for (const std::string& isa : supported_isas()) {
        const Module& module = load_module(isa);
        int in_packets = 0;
        for (std::uint32_t h = 0; h < module.hamiltonian_count; ++h)
            in_packets += expect_sweeps_of(module.hamiltonians[h], isa);
        EXPECT_GT(in_packets, 10);
    }
}

// A ray that passes a hole is deflected by the closed form of weak fields, 2 rg/b (1 + 15π rg/32b) + O(rg³/b³).
TEST(Sweep, DeflectsByTheMassOfEachSet) {
    const Sweeper sweeper{"[space]\nhamiltonian = \"schwarzschild\"\n[integrator]\nescape_radius = 1e7\n",
                          all_columns(false)};
    SweptKey rg{"space.rg", {}};
    for (int i = 0; i < 40; ++i) rg.values.push_back(1e-4 * i);
    const SweepResult result = sweeper.sweep({rg}, {{{-9e6, 1, 0}, {1, 0, 0}}});
    EXPECT_EQ(result.reason_against_packets, "");
    for (std::size_t i = 0; i < rg.values.size(); ++i) {
        const double x = rg.values[i], angle = -std::atan2(result.ends[i].v[1], result.ends[i].v[0]);
        EXPECT_NEAR(angle, 2 * x * (1 + 15 * std::numbers::pi / 32 * x), 10 * x * x * x + 3e-7 * x + 1e-12);
    }
}

// The rays near spinning holes change between ingoing and outgoing coordinates, which depend on the parameters.
TEST(Sweep, OfSpinEqualsSeparateTracesNearTheHole) {
    std::vector<RayInput> rays = passing_rays();
    for (int i = 0; i < 6; ++i) {
        rays.push_back({{2.6, 0.3 * i - 1, 0.2}, {-1, 0.3 * i, 0.1}});
        rays.push_back({{0.4, 1.7 + 0.2 * i, 0.3}, {0.1, 1, 0.1 * i}});
    }
    SweptKey spin{"space.spin", {}}, mass{"space.mass", {}};
    for (int i = 0; i <= 24; ++i) {
        spin.values.push_back(i == 24 ? 0.9999 : 0.04 * i);
        mass.values.push_back(0.8 + 0.01 * i);
    }
    for (const char* observer : {"", "static", "zamo", "falling"}) {
        SCOPED_TRACE(observer);
        Options options = all_columns(true);
        options.observer = observer_of(observer);
        const Sweeper sweeper{"[space]\nhamiltonian = \"kerr\"\n[integrator]\nescape_radius = 20\n", options};
        const SweepResult result = sweeper.sweep({spin, mass}, rays);
        EXPECT_EQ(result.reason_against_packets, "");
        expect_same_as_separate(sweeper, {spin, mass}, rays, 2e-6, result);
    }
}

TEST(Sweep, HitsSurfacesLikeSeparateTraces) {
    const Sweeper sweeper{R"([space]
hamiltonian = "schwarzschild"
center = [0.5, 0.25, 0]
[[object]]
name = "ball"
shape = "sphere"
center = [3, 1, 0]
radius = 2
[[object]]
name = "wall"
shape = "rectangle"
origin = [6, -9, -9]
edge_u = [0, 18, 0]
edge_v = [0, 0, 18]
)",
                          all_columns(true)};
    SweptKey rg{"space.rg", {}};
    for (int i = 0; i < 40; ++i) rg.values.push_back(0.02 * i);
    const SweepResult result = sweeper.sweep({rg}, passing_rays());
    EXPECT_EQ(result.reason_against_packets, "");
    const auto hits = std::count_if(result.ends.begin(), result.ends.end(),
                                    [](const RayEnd& end) { return end.status == Status::hit; });
    EXPECT_GT(hits, 100);
    expect_same_as_separate(sweeper, {rg}, passing_rays(), 1e-6, result);
}

// Lengths of this scene are converted to another unit.
TEST(Sweep, ConvertsUnits) {
    const Sweeper sweeper{"[space]\nhamiltonian = \"schwarzschild\"\n[integrator]\nescape_radius = 1e9\n",
                          all_columns(true)};
    const SweptKey rg{"space.rg", {1e7, 2e7, 3e7, 0}};
    std::vector<RayInput> rays = passing_rays();
    for (RayInput& ray : rays)
        for (double& x : ray.position) x *= 1e8;
    const SweepResult result = sweeper.sweep({rg}, rays);
    EXPECT_EQ(result.reason_against_packets, "");
    for (std::size_t set = 0; set < 4; ++set) {
        const std::vector<RayEnd> expected = sweeper.trace_set({rg}, set, rays);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            EXPECT_EQ(int(result.ends[set * rays.size() + i].status), int(expected[i].status));
            EXPECT_LE(distance(result.ends[set * rays.size() + i].q, expected[i].q), 1e2);
        }
    }
}

TEST(Sweep, PlansEachSetForOtherKeys) {
    const Sweeper scene{"[space]\nhamiltonian = \"schwarzschild\"\n", all_columns(true)};
    const std::vector<SweptKey> radius{{"integrator.escape_radius", {8, 9, 15}}, {"space.rg", {0.1, 0.2, 0.3}}};
    const SweepResult result = scene.sweep(radius, passing_rays());
    EXPECT_NE(result.reason_against_packets.find("integrator.escape_radius is not a parameter"), std::string::npos);
    expect_same_as_separate(scene, radius, passing_rays(), 1e-12, result);
}

// The kernel for packets of different sets does not support these scenes. Their sets are traced separately, with the
// same steps as by a plan of each set.
TEST(Sweep, StatesWhySetsDoNotSharePackets) {
    const std::string kerr = "[space]\nhamiltonian = \"kerr\"\n";
    const std::string ball = "[[object]]\nname = \"ball\"\nshape = \"sphere\"\ncenter = [5, 1, 0]\nradius = 2\n";
    Options bounces = all_columns(true), scalar = all_columns(true), single = all_columns(true);
    bounces.bounces = 2;
    scalar.strategy = Strategy::scalar;
    single.precision = Precision::float32;
    struct Case {
        Sweeper sweeper;
        std::string reason;
    };
    const Case cases[] = {
        {{kerr + ball, all_columns(true)}, "surfaces near a spinning hole"},
        {{kerr + "[[object]]\nname = \"disk\"\nshape = \"disk\"\ncenter = [0, 0, 0]\nnormal = [0, 0, 1]\ninner = "
                 "6\nouter = 9\ntemperature = 5000\n",
          all_columns(true)},
         "matter of a disk"},
        {{kerr + ball + "material = \"mirror\"\n", bounces}, "continue at surfaces"},
        {{kerr, scalar}, "only packets of double"},
        {{kerr, single}, "only packets of double"},
        {{kerr + "[integrator]\nrescale = \"r\"\n", all_columns(true)}, "integrator.rescale"},
        {{kerr + "[integrator]\nrescale = \"none\"\n", all_columns(true)}, "time rescaling"},
        {{kerr + "[integrator]\nmethod = \"gauss8\"\n", all_columns(true)}, "do not adapt"},
    };
    const std::vector<SweptKey> spin{{"space.spin", {0.1, 0.5, 0.9}}};
    for (const Case& c : cases) {
        const SweepResult result = c.sweeper.sweep(spin, passing_rays());
        EXPECT_NE(result.reason_against_packets.find(c.reason), std::string::npos)
            << c.sweeper.text << result.reason_against_packets;
        for (std::size_t set = 0; set < 3; ++set) {
            const std::vector<RayEnd> expected = c.sweeper.trace_set(spin, set, passing_rays());
            for (std::size_t i = 0; i < expected.size(); ++i) {
                const RayEnd& end = result.ends[set * expected.size() + i];
                EXPECT_EQ(int(end.status), int(expected[i].status)) << c.reason;
                EXPECT_EQ(end.steps, expected[i].steps) << c.reason;
                EXPECT_LE(distance(end.q, expected[i].q), 1e-9) << c.reason;
            }
        }
    }
}

TEST(Sweep, IsDividedOverThreadsWithoutEffectOnResults) {
    Sweeper sweeper{"[space]\nhamiltonian = \"kerr\"\n", all_columns(true)};
    SweptKey spin{"space.spin", {}};
    for (int i = 0; i < 700; ++i) spin.values.push_back(0.001 * i);
    const SweepResult two = sweeper.sweep({spin}, passing_rays());
    sweeper.options.threads = 1;
    const SweepResult one = sweeper.sweep({spin}, passing_rays());
    for (std::size_t i = 0; i < one.ends.size(); ++i) {
        EXPECT_EQ(one.ends[i].q[0], two.ends[i].q[0]);
        EXPECT_EQ(one.ends[i].steps, two.ends[i].steps);
    }
}

TEST(Sweep, MarksRaysThatWereNotTraced) {
    const Sweeper sweeper{"[space]\nhamiltonian = \"schwarzschild\"\n", all_columns(true)};
    const std::atomic<bool> stop = true;
    RunControl control;
    control.stop = &stop;
    for (const char* key : {"space.rg", "integrator.escape_radius"}) {
        const SweepResult result = sweep(sweeper.plan_with(), {{key, {20, 30}}}, {{{5, 1, 0}, {1, 0, 0}}}, {}, control);
        EXPECT_TRUE(result.interrupted);
        ASSERT_EQ(result.ends.size(), 2u);
        for (const RayEnd& end : result.ends) {
            EXPECT_EQ(int(end.failure), int(Failure::untraced));
            EXPECT_EQ(end.q[0], 5);
        }
    }
}

/// Returns the message of the InputError that a sweep throws; "" if it throws none.
std::string error_of(const std::vector<SweptKey>& keys) {
    const Sweeper sweeper{"[space]\nhamiltonian = \"shimmer\"\n", all_columns(false)};
    try {
        sweeper.sweep(keys, passing_rays());
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

TEST(Sweep, RefusesWrongInput) {
    const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
    const auto expect = [](const std::vector<SweptKey>& keys, const std::vector<std::string>& parts) {
        const std::string message = error_of(keys);
        for (const std::string& part : parts) EXPECT_NE(message.find(part), std::string::npos) << message;
    };
    expect({}, {"at least one key"});
    expect({{"space.n0", {}}}, {"space.n0 has no values"});
    expect({{"space.n0", {1, 2}}, {"space.seed", {1, 2, 3}}}, {"space.seed has 3 values", "space.n0 has 2"});
    expect({{"space.n0", {1}}, {"space.n0", {1}}}, {"space.n0 occurs twice"});
    expect({{"space.n00", {1, 2}}}, {"set 0 of the sweep", "n00", "n0"});
    expect({{"space.n0", {1, 2, -1}}}, {"value 2 of space.n0", "space.n0 = -1", "legal range"});
    expect({{"space.n0", {-1, 2, 1}}}, {"set 0 of the sweep", "space.n0 = -1", "legal range"});
    expect({{"space.n0", {1, nan}}}, {"value 1 of space.n0", "nan", "finite"});
    expect({{"space.n0", {1, infinity}}}, {"value 1 of space.n0", "inf", "finite"});
    expect({{"space.seed", {1, 2.5}}}, {"value 1 of space.seed", "2.5", "whole number"});
    expect({{"integrator.escape_radius", {5, 0}}}, {"set 1 of the sweep", "escape_radius = 0", "legal range"});
}

}  // namespace
}  // namespace kagero::test

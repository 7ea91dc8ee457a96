// Compares steps of packets, lane by lane, with scalar steps of the same rays. The results must be equal bit for bit,
// whatever the other lanes contain. Packets and the standard library round exp, log and tanh differently. If H contains
// one of these functions, the results must be equal to rounding.
#include "tests/kernels/steps.h"

#include "kernels/trace/packets.h"

namespace kagero::test {
namespace {

template <class H>
class Strategies : public ::testing::Test {};
TYPED_TEST_SUITE(Strategies, AllHamiltonians, HamiltonianName);

/// Returns true if two numbers are equal or both NaN. Zeros of either sign are equal, because the compiler may exchange
/// them.
template <class S>
bool equal_or_both_nan(S a, S b) { return a == b || (a != a && b != b); }

/// Returns all results of a step in one lane.
template <class V>
std::vector<ScalarOf<V>> results_in_lane(const StepperState<V>& state, int lane) {
    std::vector<ScalarOf<V>> values;
    const auto add = [&](const V& v) { values.push_back(get_lane(v, lane)); };
    for (int k = 0; k < 7; ++k) add(state.end.y[k]);
    add(state.end.velocity.x);
    add(state.end.velocity.y);
    add(state.end.velocity.z);
    add(state.end.parameter);
    add(state.energy);
    add(state.energy_error);
    add(state.end.domain);
    add(state.end.captured);
    add(state.gradients);
    add(state.lane_iterations);
    values.push_back(static_cast<ScalarOf<V>>((to_bits(state.solved) >> lane) & 1));
    return values;
}

template <class S>
void expect_same(const std::vector<S>& a, const std::vector<S>& b, const std::string& description) {
    for (std::size_t i = 0; i < a.size(); ++i)
        EXPECT_TRUE(equal_or_both_nan(a[i], b[i])) << description << ", value " << i << ": " << a[i] << " and " << b[i]
                                                   << ", difference " << a[i] - b[i];
}

template <class V>
State<V> packet_of(const std::vector<RayStart>& rays) {
    State<V> s;
    for (int i = 0; i < lane_count<V>; ++i) {
        const auto scalar = state_of<ScalarOf<V>>(rays[static_cast<std::size_t>(i)]);
        for (int k = 0; k < 7; ++k) set_lane(s.y[k], i, scalar.y[k]);
    }
    return s;
}

/// Expects that the results in a lane agree with a scalar step within `tolerance`, relative to 1 + |value|. Leaves out
/// the numbers of gradients and iterations, which a rounding error can change.
template <class V>
void expect_near(const StepperState<V>& packet, int lane, const StepperState<ScalarOf<V>>& scalar, double tolerance) {
    using S = ScalarOf<V>;
    const auto check = [&](const V& packet_value, S scalar_value, int i) {
        EXPECT_NEAR(get_lane(packet_value, lane), scalar_value, tolerance * (1 + std::abs(scalar_value)))
            << "lane " << lane << ", value " << i;
    };
    for (int k = 0; k < 7; ++k) check(packet.end.y[k], scalar.end.y[k], k);
    check(packet.end.velocity.x, scalar.end.velocity.x, 7);
    check(packet.end.velocity.y, scalar.end.velocity.y, 8);
    check(packet.end.velocity.z, scalar.end.velocity.z, 9);
    check(packet.end.parameter, scalar.end.parameter, 10);
    check(packet.energy, scalar.energy, 11);
    check(packet.end.domain, scalar.end.domain, 12);
    EXPECT_EQ((to_bits(packet.solved) >> lane) & 1, to_bits(scalar.solved)) << "lane " << lane;
}

template <class H, class V>
void expect_lanes_match_scalars() {
    using S = ScalarOf<V>;
    const auto rays = random_rays<H>(lane_count<V>, 5);
    for_all_methods<H>([&](const Method& method, bool rescaled) {
        const S h = S(path_length<H> / 64);
        auto packet = SpaceStepper<V>::template for_space<H>(method, rescaled);
        packet.begin(packet_of<V>(rays), V(h));
        auto scalars = std::vector(lane_count<V>, SpaceStepper<S>::template for_space<H>(method, rescaled));
        for (int i = 0; i < lane_count<V>; ++i) scalars[i].begin(state_of<S>(rays[i]), h);
        int total_steps = 0;
        for (const int steps : {1, 31}) {
            packet.advance(steps);
            total_steps += steps;
            for (int i = 0; i < lane_count<V>; ++i) {
                scalars[i].advance(steps);
                if (!has_exp_log_or_tanh<H>())
                    expect_same(results_in_lane(packet.state, i), results_in_lane(scalars[i].state, 0),
                                "lane " + std::to_string(i));
                else
                    expect_near(packet.state, i, scalars[i].state,
                                100 * total_steps * stages_of(method) * machine_epsilon<S>);
            }
        }
    });
}
TYPED_TEST(Strategies, LanesOfDoubleMatchScalars) { expect_lanes_match_scalars<TypeParam, PacketDouble>(); }
TYPED_TEST(Strategies, LanesOfFloatMatchScalars) { expect_lanes_match_scalars<TypeParam, PacketFloat>(); }

/// Returns six ray starts from which no method can integrate.
std::vector<RayStart> invalid_starts(const RayStart& valid) {
    const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
    std::vector<RayStart> invalid_rays(6, valid);
    for (int k = 0; k < 3; ++k) {
        invalid_rays[0].q[k] = nan;
        invalid_rays[1].q[k] = infinity;
        invalid_rays[2].q[k] = 0;
    }
    invalid_rays[3].p[1] = nan;
    invalid_rays[4].p[0] = -infinity;
    invalid_rays[5].p[2] = 1e30;
    return invalid_rays;
}

/// Compares the steps of a packet that has an invalid start in one lane with the steps of a packet of valid starts.
template <class H, class V>
void expect_other_lanes_unchanged() {
    using S = ScalarOf<V>;
    const auto valid = random_rays<H>(lane_count<V>, 7);
    const auto invalid_rays = invalid_starts(valid[0]);
    for_all_methods<H>([&](const Method& method, bool rescaled) {
        const auto run = [&](const std::vector<RayStart>& rays) {
            auto stepper = SpaceStepper<V>::template for_space<H>(method, rescaled);
            stepper.begin(packet_of<V>(rays), V(S(path_length<H> / 64)));
            stepper.advance(8);
            return stepper;
        };
        const auto expected = run(valid);
        for (std::size_t j = 0; j < invalid_rays.size(); ++j) {
            auto rays = valid;
            const int invalid_lane = static_cast<int>(j) % lane_count<V>;
            rays[static_cast<std::size_t>(invalid_lane)] = invalid_rays[j];
            const auto result = run(rays);
            for (int i = 0; i < lane_count<V>; ++i) {
                if (i == invalid_lane) continue;
                expect_same(results_in_lane(result.state, i), results_in_lane(expected.state, i),
                            "lane " + std::to_string(i) + " with invalid start " + std::to_string(j));
            }
        }
    });
}
TYPED_TEST(Strategies, InvalidStartsDoNotChangeOtherLanesInDouble) {
    expect_other_lanes_unchanged<TypeParam, PacketDouble>();
}
TYPED_TEST(Strategies, InvalidStartsDoNotChangeOtherLanesInFloat) {
    expect_other_lanes_unchanged<TypeParam, PacketFloat>();
}

// Lanes whose rays have terminated take steps of length 0. Such a step must be solved and must not change the
// state.
TYPED_TEST(Strategies, StepsOfLengthZeroAreTheIdentity) {
    using H = TypeParam;
    const auto rays = random_rays<H>(lane_count<PacketDouble>, 9);
    for_all_methods<H>([&](const Method& method, bool rescaled) {
        auto stepper = SpaceStepper<PacketDouble>::for_space<H>(method, rescaled);
        const auto start = packet_of<PacketDouble>(rays);
        stepper.begin(start, PacketDouble(0.0));
        stepper.advance(3);
        for (int i = 0; i < lane_count<PacketDouble>; ++i) {
            EXPECT_TRUE((to_bits(stepper.state.solved) >> i) & 1);
            for (int k = 0; k < 7; ++k) {
                // The ExactSplit stepper computes r and q/r also in a step of length 0, so that its results are
                // rounded.
                const double end = get_lane(stepper.state.end.y[k], i), expected = get_lane(start.y[k], i);
                if (method.kind == StepperKind::exact_split)
                    EXPECT_NEAR(end, expected, 256 * machine_epsilon<double> * (1 + std::abs(expected)));
                else EXPECT_EQ(end, expected);
            }
        }
    });
}

}  // namespace
}  // namespace kagero::test

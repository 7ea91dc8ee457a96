// Every ray of a packet takes the steps that it takes alone, to the last bit, whatever its neighbours do. Packets have
// their own sines and exponentials, as good as the standard library's but not the same: where H uses one, the steps
// agree to rounding.
#include "tests/kernels/steps.h"

#include "kernels/trace/packets.h"

namespace kagero::test {
namespace {

template <class H>
class Strategies : public ::testing::Test {};
TYPED_TEST_SUITE(Strategies, AllHamiltonians, HamiltonianName);

/// The same bits, where zeros of either sign (which compilers may exchange here) and all NaN count as one.
template <class S>
bool same(S a, S b) { return a == b || (a != a && b != b); }

/// All that a step leaves behind for one ray.
template <class V>
std::vector<ScalarOf<V>> outcome(const StepperState<V>& f, int lane) {
    std::vector<ScalarOf<V>> values;
    const auto add = [&](const V& v) { values.push_back(get_lane(v, lane)); };
    for (int k = 0; k < 7; ++k) add(f.end.y[k]);
    add(f.end.velocity.x), add(f.end.velocity.y), add(f.end.velocity.z);
    add(f.end.parameter), add(f.energy), add(f.energy_error), add(f.end.domain), add(f.end.captured), add(f.gradients),
        add(f.open_iterations);
    values.push_back(static_cast<ScalarOf<V>>((to_bits(f.solved) >> lane) & 1));
    return values;
}

template <class S>
void expect_same(const std::vector<S>& a, const std::vector<S>& b, const std::string& what) {
    for (std::size_t i = 0; i < a.size(); ++i)
        EXPECT_TRUE(same(a[i], b[i])) << what << ", value " << i << ": " << a[i] << " and " << b[i] << ", apart by "
                                      << a[i] - b[i];
}

template <class V>
State<V> packet_of(const std::vector<RayStart>& rays) {
    State<V> s;
    for (int i = 0; i < lane_count<V>; ++i) {
        const auto one = state_of<ScalarOf<V>>(rays[static_cast<std::size_t>(i)]);
        for (int k = 0; k < 7; ++k) set_lane(s.y[k], i, one.y[k]);
    }
    return s;
}

/// The end of the ray, without the counts that a rounding may change.
template <class V>
void expect_near(const StepperState<V>& packet, int lane, const StepperState<ScalarOf<V>>& alone, double tolerance) {
    using S = ScalarOf<V>;
    const std::string what = "lane " + std::to_string(lane);
    const auto check = [&](const V& together, S single, int i) {
        EXPECT_NEAR(get_lane(together, lane), single, tolerance * (1 + std::abs(single))) << what << ", value " << i;
    };
    for (int k = 0; k < 7; ++k) check(packet.end.y[k], alone.end.y[k], k);
    check(packet.end.velocity.x, alone.end.velocity.x, 7), check(packet.end.velocity.y, alone.end.velocity.y, 8);
    check(packet.end.velocity.z, alone.end.velocity.z, 9), check(packet.end.parameter, alone.end.parameter, 10);
    check(packet.energy, alone.energy, 11), check(packet.end.domain, alone.end.domain, 12);
    EXPECT_EQ((to_bits(packet.solved) >> lane) & 1, to_bits(alone.solved)) << what;
}

template <class H, class V>
void expect_lanes_are_scalars() {
    using S = ScalarOf<V>;
    const auto rays = random_rays<H>(lane_count<V>, 5);
    for_all_methods<H>([&](const Method& method, bool rescaled) {
        const S h = S(path_length<H> / 64);
        auto together = Steps<V>::template in<H>(method, rescaled);
        together.begin(packet_of<V>(rays), V(h));
        auto alone = std::vector(lane_count<V>, Steps<S>::template in<H>(method, rescaled));
        for (int i = 0; i < lane_count<V>; ++i) alone[i].begin(state_of<S>(rays[i]), h);
        int taken = 0;
        for (const int steps : {1, 31}) {
            together.advance(steps), taken += steps;
            for (int i = 0; i < lane_count<V>; ++i) {
                alone[i].advance(steps);
                if (!is_transcendental<H>())
                    expect_same(outcome(together.flow, i), outcome(alone[i].flow, 0), "lane " + std::to_string(i));
                else expect_near(together.flow, i, alone[i].flow, 100 * taken * stages_of(method) * machine_epsilon<S>);
            }
        }
    });
}
TYPED_TEST(Strategies, LanesOfDoubleAreScalars) { expect_lanes_are_scalars<TypeParam, PacketDouble>(); }
TYPED_TEST(Strategies, LanesOfFloatAreScalars) { expect_lanes_are_scalars<TypeParam, PacketFloat>(); }

/// Starts that no method can use.
std::vector<RayStart> garbage(const RayStart& healthy) {
    const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
    std::vector<RayStart> bad(6, healthy);
    for (int k = 0; k < 3; ++k) bad[0].q[k] = nan, bad[1].q[k] = infinity, bad[2].q[k] = 0;
    bad[3].p[1] = nan, bad[4].p[0] = -infinity, bad[5].p[2] = 1e30;
    return bad;
}

template <class H, class V>
void expect_neighbours_unmoved() {
    using S = ScalarOf<V>;
    const auto healthy = random_rays<H>(lane_count<V>, 7);
    const auto bad = garbage(healthy[0]);
    for_all_methods<H>([&](const Method& method, bool rescaled) {
        const auto run = [&](const std::vector<RayStart>& rays) {
            auto steps = Steps<V>::template in<H>(method, rescaled);
            steps.begin(packet_of<V>(rays), V(S(path_length<H> / 64)));
            steps.advance(8);
            return steps;
        };
        const auto expected = run(healthy);
        for (std::size_t kind = 0; kind < bad.size(); ++kind) {
            auto rays = healthy;
            const int place = static_cast<int>(kind) % lane_count<V>;
            rays[static_cast<std::size_t>(place)] = bad[kind];
            const auto disturbed = run(rays);
            for (int i = 0; i < lane_count<V>; ++i) {
                if (i == place) continue;
                expect_same(outcome(disturbed.flow, i), outcome(expected.flow, i),
                            "lane " + std::to_string(i) + " beside garbage " + std::to_string(kind));
            }
        }
    });
}
TYPED_TEST(Strategies, GarbageLeavesItsNeighboursInDouble) { expect_neighbours_unmoved<TypeParam, PacketDouble>(); }
TYPED_TEST(Strategies, GarbageLeavesItsNeighboursInFloat) { expect_neighbours_unmoved<TypeParam, PacketFloat>(); }

// A finished lane takes steps of length zero: it stays where it is and counts as solved.
TYPED_TEST(Strategies, AStepOfLengthZeroIsTheIdentity) {
    using H = TypeParam;
    const auto rays = random_rays<H>(lane_count<PacketDouble>, 9);
    for_all_methods<H>([&](const Method& method, bool rescaled) {
        auto steps = Steps<PacketDouble>::in<H>(method, rescaled);
        const auto start = packet_of<PacketDouble>(rays);
        steps.begin(start, PacketDouble(0.0));
        steps.advance(3);
        for (int i = 0; i < lane_count<PacketDouble>; ++i) {
            EXPECT_TRUE((to_bits(steps.flow.solved) >> i) & 1);
            for (int k = 0; k < 7; ++k) {
                // The exact split goes through r and n = q/r even then: to rounding.
                const double is = get_lane(steps.flow.end.y[k], i), was = get_lane(start.y[k], i);
                if (method.kind == Kind::exact_split)
                    EXPECT_NEAR(is, was, 256 * machine_epsilon<double> * (1 + std::abs(was)));
                else EXPECT_EQ(is, was);
            }
        }
    });
}

}  // namespace
}  // namespace kagero::test

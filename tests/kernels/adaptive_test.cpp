// Tests of adaptive methods. A smaller tolerance must give a smaller error. The step of each lane must be accepted or
// rejected independently of the other lanes.
#include "tests/support/greatest.h"
#include "tests/kernels/steps.h"

#include "kernels/trace/packets.h"

#include <algorithm>

namespace kagero::test {
namespace {

template <class H>
class AdaptiveMethods : public ::testing::Test {};
TYPED_TEST_SUITE(AdaptiveMethods, AllHamiltonians, HamiltonianName);

/// Calls check(method, rescaled) for all adaptive methods that support H.
template <class H, class Check>
void for_adaptive_methods(const Check& check) {
    for_all_methods<H>([&](const Method& method, bool rescaled) {
        if (method.info.adaptive) check(method, rescaled);
    });
}

/// The end of an integrated path, and the numbers of accepted and rejected steps.
struct Path {
    State<double> end;
    int accepted = 0, rejected = 0;
};
/// Integrates bent ray number `ray` over `path_length`, with the step lengths that the method suggests.
template <class H>
Path integrate(const Method& method, bool rescaled, int ray, double tolerance) {
    auto stepper = SpaceStepper<double>::for_space<H>(method, rescaled);
    stepper.state.options.tolerance = tolerance;
    stepper.begin(state_of<double>(bent_ray<H>(ray)), path_length<H> / 2);
    Path path;
    double remaining = path_length<H>;
    while (remaining > 0 && path.accepted + path.rejected < 10000) {
        const bool last = stepper.state.h >= remaining;
        if (last) stepper.state.h = remaining;
        stepper.step();
        if (stepper.state.accepted) {
            remaining = last ? 0 : remaining - stepper.state.h;
            stepper.state.start = stepper.state.end;
            ++path.accepted;
        } else {
            EXPECT_LT(stepper.state.suggested_length, stepper.state.h)
                << "The length suggested after a rejected step must be shorter.";
            ++path.rejected;
        }
        stepper.state.h = stepper.state.suggested_length;
    }
    path.end = stepper.state.start;
    EXPECT_EQ(remaining, 0) << "The path is not complete after 10000 steps.";
    return path;
}

/// Returns the end of the path of bent ray number `ray`, computed by a collocation method of order 12 with 64 steps.
template <class H>
State<double> reference(bool rescaled, int ray) {
    constexpr int steps = 64;
    auto stepper = SpaceStepper<double>::for_space<H>(method_named("gauss12"), rescaled);
    stepper.begin(state_of<double>(bent_ray<H>(ray)), path_length<H> / steps);
    stepper.advance(steps);
    return stepper.state.end;
}

TYPED_TEST(AdaptiveMethods, ErrorDecreasesWithTheTolerance) {
    using H = TypeParam;
    for_adaptive_methods<H>([](const Method& method, bool rescaled) {
        double previous_error = 1;
        int previous_steps = 0;
        for (const double tolerance : {1e-3, 1e-6, 1e-9, 1e-12}) {
            double error = 0;
            int steps = 0;
            for (int ray = 0; ray < bent_ray_count; ++ray) {
                const Path path = integrate<H>(method, rescaled, ray, tolerance);
                const State<double> exact = reference<H>(rescaled, ray);
                for (int k = 0; k < 6; ++k)
                    error = greatest(error, std::abs(path.end.y[k] - exact.y[k]) / (1 + std::abs(exact.y[k])));
                steps += path.accepted;
            }
            // The error is at most the sum of the local errors, which the flow magnifies by less than 10.
            EXPECT_LE(error, 10 * steps * tolerance + 1e4 * machine_epsilon<double>) << "tolerance " << tolerance;
            // The error must decrease, unless it is far below the tolerance. Such small errors vary irregularly,
            // because the error estimate has a lower order than the step.
            EXPECT_LE(error, std::max(previous_error, 0.01 * tolerance) + 1e4 * machine_epsilon<double>)
                << "tolerance " << tolerance;
            EXPECT_GE(steps, previous_steps) << "tolerance " << tolerance;
            previous_error = error;
            previous_steps = steps;
        }
    });
}

/// Performs one step of a packet whose lanes have very different step lengths. Expects that each lane is accepted or
/// rejected in the same way, and gets the same suggested length, as in a scalar step of this length.
template <class H, class V>
void expect_independent_lanes() {
    using S = ScalarOf<V>;
    const State<S> start = state_of<S>(bent_ray<H>());
    State<V> packet_start;
    for (int k = 0; k < 7; ++k) packet_start.y[k] = V(start.y[k]);
    V h;
    for (int i = 0; i < lane_count<V>; ++i) set_lane(h, i, S(path_length<H> * std::ldexp(1.5, -i)));
    for_adaptive_methods<H>([&](const Method& method, bool rescaled) {
        auto packet = SpaceStepper<V>::template for_space<H>(method, rescaled);
        packet.state.options.tolerance = S(1e-4);
        packet.begin(packet_start, h);
        packet.step();
        const std::uint64_t accepted = to_bits(packet.state.accepted);
        for (int i = 0; i < lane_count<V>; ++i) {
            auto scalar = SpaceStepper<S>::template for_space<H>(method, rescaled);
            scalar.state.options.tolerance = S(1e-4);
            scalar.begin(start, get_lane(h, i));
            scalar.step();
            const S suggested_length = scalar.state.suggested_length, length = get_lane(h, i);
            EXPECT_EQ((accepted >> i) & 1, to_bits(scalar.state.accepted)) << "lane " << i;
            EXPECT_TRUE(scalar.state.accepted || suggested_length < length) << "lane " << i;
            // The error estimate is a small difference of large numbers, so that its relative rounding error is that of
            // the state divided by the tolerance.
            const S rounding = machine_epsilon<S> / S(1e-4);
            EXPECT_NEAR(get_lane(packet.state.suggested_length, i), suggested_length, 100 * rounding * suggested_length)
                << "lane " << i;
        }
    });
}
TYPED_TEST(AdaptiveMethods, LanesAreAcceptedIndependentlyInDouble) {
    expect_independent_lanes<TypeParam, PacketDouble>();
}
TYPED_TEST(AdaptiveMethods, LanesAreAcceptedIndependentlyInFloat) {
    expect_independent_lanes<TypeParam, PacketFloat>();
}

}  // namespace
}  // namespace kagero::test

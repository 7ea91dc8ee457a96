// Step control: a smaller tolerance gives a smaller error, and each ray is accepted or rejected for itself.
#include "tests/support/greatest.h"
#include "tests/kernels/steps.h"

#include "kernels/trace/packets.h"

#include <algorithm>

namespace kagero::test {
namespace {

template <class H>
class Adaptive : public ::testing::Test {};
TYPED_TEST_SUITE(Adaptive, AllHamiltonians, HamiltonianName);

template <class H, class Check>
void for_adaptive_methods(const Check& check) {
    for_all_methods<H>([&](const Method& method, bool rescaled) {
        if (method.info.adaptive) check(method, rescaled);
    });
}

struct Followed {
    State<double> end;
    int accepted = 0, rejected = 0;
};
/// The whole path with the steps that the method suggests.
template <class H>
Followed follow(const Method& method, bool rescaled, int ray, double tolerance) {
    auto steps = Steps<double>::in<H>(method, rescaled);
    steps.flow.options.tolerance = tolerance;
    steps.begin(state_of<double>(bent_ray<H>(ray)), path_length<H> / 2);
    Followed run;
    double left = path_length<H>;
    while (left > 0 && run.accepted + run.rejected < 10000) {
        const bool last = steps.flow.h >= left;
        if (last) steps.flow.h = left;
        steps.step();
        if (steps.flow.accepted) {
            left = last ? 0 : left - steps.flow.h;
            steps.flow.start = steps.flow.end;
            ++run.accepted;
        } else {
            EXPECT_LT(steps.flow.suggested, steps.flow.h) << "a rejected step must become shorter";
            ++run.rejected;
        }
        steps.flow.h = steps.flow.suggested;
    }
    run.end = steps.flow.start;
    EXPECT_EQ(left, 0) << "never arrives";
    return run;
}

/// The same path by collocation.
template <class H>
State<double> reference(bool rescaled, int ray) {
    constexpr int steps = 64;
    auto exact = Steps<double>::in<H>(method_named("gauss12"), rescaled);
    exact.begin(state_of<double>(bent_ray<H>(ray)), path_length<H> / steps);
    exact.advance(steps);
    return exact.flow.end;
}

TYPED_TEST(Adaptive, ErrorFollowsTheTolerance) {
    using H = TypeParam;
    for_adaptive_methods<H>([](const Method& method, bool rescaled) {
        double before = 1;
        int steps_before = 0;
        for (const double tolerance : {1e-3, 1e-6, 1e-9, 1e-12}) {
            double error = 0;
            int steps = 0;
            for (int ray = 0; ray < bent_rays; ++ray) {
                const Followed run = follow<H>(method, rescaled, ray, tolerance);
                const State<double> exact = reference<H>(rescaled, ray);
                for (int k = 0; k < 6; ++k)
                    error = greatest(error, std::abs(run.end.y[k] - exact.y[k]) / (1 + std::abs(exact.y[k])));
                steps += run.accepted;
            }
            // Local errors add up, and the flow stretches them a little.
            EXPECT_LE(error, 10 * steps * tolerance + 1e4 * machine_epsilon<double>) << "tolerance " << tolerance;
            // Far below the tolerance, where an estimate is of a lower order than the step, errors come as they may.
            EXPECT_LE(error, std::max(before, 0.01 * tolerance) + 1e4 * machine_epsilon<double>)
                << "tolerance " << tolerance;
            EXPECT_GE(steps, steps_before) << "tolerance " << tolerance;
            before = error, steps_before = steps;
        }
    });
}

/// Lanes with steps from tiny to enormous: each is judged as if it were alone.
template <class H, class V>
void expect_judged_alone() {
    using S = ScalarOf<V>;
    const State<S> start = state_of<S>(bent_ray<H>());
    State<V> all;
    for (int k = 0; k < 7; ++k) all.y[k] = V(start.y[k]);
    V h;
    for (int i = 0; i < lane_count<V>; ++i) set_lane(h, i, S(path_length<H> * std::ldexp(1.5, -i)));
    for_adaptive_methods<H>([&](const Method& method, bool rescaled) {
        auto together = Steps<V>::template in<H>(method, rescaled);
        together.flow.options.tolerance = S(1e-4);
        together.begin(all, h);
        together.step();
        const std::uint64_t accepted = to_bits(together.flow.accepted);
        for (int i = 0; i < lane_count<V>; ++i) {
            auto alone = Steps<S>::template in<H>(method, rescaled);
            alone.flow.options.tolerance = S(1e-4);
            alone.begin(start, get_lane(h, i));
            alone.step();
            const S suggested = alone.flow.suggested, length = get_lane(h, i);
            EXPECT_EQ((accepted >> i) & 1, to_bits(alone.flow.accepted)) << "lane " << i;
            EXPECT_TRUE(alone.flow.accepted || suggested < length) << "lane " << i;
            // The estimate is a small difference of large numbers.
            const S rounding = machine_epsilon<S> / S(1e-4);
            EXPECT_NEAR(get_lane(together.flow.suggested, i), suggested, 100 * rounding * suggested) << "lane " << i;
        }
    });
}
TYPED_TEST(Adaptive, LanesAreJudgedAloneInDouble) { expect_judged_alone<TypeParam, PacketDouble>(); }
TYPED_TEST(Adaptive, LanesAreJudgedAloneInFloat) { expect_judged_alone<TypeParam, PacketFloat>(); }

}  // namespace
}  // namespace kagero::test

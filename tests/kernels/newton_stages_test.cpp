// Steps that fixed-point iteration cannot take: Newton's method solves the same equations, on the branch that grows out
// of the start.
#include "tests/kernels/steps.h"

#include "kernels/hamiltonians/fiber.h"
#include "kernels/hamiltonians/fisheye.h"
#include "kernels/trace/packets.h"

#include <complex>

namespace kagero::test {
namespace {

using hamiltonians::Fiber;
using hamiltonians::Fisheye;

/// The diagonal Padé approximant of exp(z), by which collocation at Gauss's points takes a linear oscillator (Hairer &
/// Wanner 1996, §IV.3).
std::complex<double> pade(int s, std::complex<double> z) {
    std::complex<double> above = 1, below = 1, power = 1;
    double c = 1;
    for (int k = 1; k <= s; ++k) {
        c *= double(s - k + 1) / double(k * (2 * s - k + 1));
        power *= z;
        above += c * power, below += (k % 2 ? -c : c) * power;
    }
    return above / below;
}

template <class V>
void expect_pade(const char* name) {
    using S = ScalarOf<V>;
    const Method& method = method_named(name);
    const double n0 = default_parameters<Fiber>()[0], alpha = default_parameters<Fiber>()[1], omega = n0 * alpha;
    for (const double turn : {0.5, 4.0, 8.0, 12.0}) {
        SCOPED_TRACE(turn);
        auto steps = Steps<V>::template in<Fiber>(method, false);
        const State<double> start{{0.4, -0.3, 0.1, 0.2, 0.25, 1.2, 0}};
        State<V> lanes;
        for (int k = 0; k < 7; ++k) lanes.y[k] = V(S(start.y[k]));
        const double h = turn / omega;
        steps.begin(lanes, V(S(h)));
        steps.step();
        EXPECT_TRUE(to_bits(steps.flow.solved) & 1);
        const std::complex<double> r = pade(stages_of(method), {0, turn});
        const auto at = [&](int k) { return double(get_lane(steps.flow.end.y[k], lane_count<V> - 1)); };
        const double rounding = 1e3 * double(machine_epsilon<S>);
        for (int k = 0; k < 2; ++k) {
            // q + i p/ω turns clockwise.
            const std::complex<double> end = std::conj(r) * std::complex<double>(start.y[k], start.y[3 + k] / omega);
            EXPECT_NEAR(at(k), end.real(), rounding);
            EXPECT_NEAR(at(3 + k), omega * end.imag(), rounding);
        }
        EXPECT_NEAR(at(2), start.y[2] + h * start.y[5], rounding * h);
    }
}

TEST(NewtonStages, TakeLongStepsOfAnOscillator) {
    for (const char* method : {"midpoint", "gauss4", "gauss6", "gauss8", "gauss12", "gauss16"}) {
        SCOPED_TRACE(method);
        expect_pade<double>(method);
        expect_pade<PacketDouble>(method);
        expect_pade<PacketFloat>(method);
    }
}

/// The end of one step of length h in the fisheye, in the first lane, and whether Newton's method was needed.
struct Long {
    bool solved, newton;
    std::array<double, 6> end;
};
Long long_step(const Method& method, double h) {
    auto steps = Steps<double>::in<Fisheye>(method, false);
    steps.begin(state_of<double>(bent_ray<Fisheye>()), h);
    steps.step();
    Long all{steps.flow.solved, double(steps.flow.open_iterations) > Convergence<double>::max_iterations, {}};
    std::copy(steps.flow.end.y, steps.flow.end.y + 6, all.end.begin());
    return all;
}

// Of these methods only gauss4 has steps here that fixed points do not solve, but Newton's method does.
TEST(NewtonStages, StayOnTheBranchThatGrowsOutOfTheStart) {
    bool needed = false;
    for (const char* name : {"gauss4", "gauss8", "gauss16"}) {
        SCOPED_TRACE(name);
        const Method& method = method_named(name);
        constexpr double ratio = 1.002;
        Long last = long_step(method, 0.01);
        for (double h = 0.01 * ratio; h < 10; h *= ratio) {
            const Long next = long_step(method, h);
            if (!next.solved) break;
            needed = needed || next.newton;
            // The end moves about as fast as light does; on another branch it would be somewhere else.
            for (int k = 0; k < 6; ++k)
                EXPECT_NEAR(next.end[k], last.end[k], 20 * (ratio - 1) * h) << "h = " << h << ", component " << k;
            last = next;
        }
    }
    EXPECT_TRUE(needed);
}

}  // namespace
}  // namespace kagero::test

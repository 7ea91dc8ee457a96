// Tests steps of collocation methods that are so long that fixed-point iteration does not converge. Newton's method
// must find the solution that moves continuously from the start of the step as the step length increases from 0.
#include "tests/kernels/steps.h"

#include "kernels/hamiltonians/fiber.h"
#include "kernels/hamiltonians/fisheye.h"
#include "kernels/trace/packets.h"

#include <complex>

namespace kagero::test {
namespace {

using hamiltonians::Fiber;
using hamiltonians::Fisheye;

/// Returns the diagonal Padé approximant (s, s) of exp(z). It is the stability function of Gauss collocation with s
/// stages: one step of a linear oscillator multiplies its amplitude by this number (Hairer & Wanner 1996, §IV.3).
std::complex<double> pade(int s, std::complex<double> z) {
    std::complex<double> numerator = 1, denominator = 1, power = 1;
    double c = 1;
    for (int k = 1; k <= s; ++k) {
        c *= double(s - k + 1) / double(k * (2 * s - k + 1));
        power *= z;
        numerator += c * power;
        denominator += (k % 2 ? -c : c) * power;
    }
    return numerator / denominator;
}

/// Compares one step in the optical fiber, whose rays are harmonic in x and y, with the Padé approximant. `phase` is
/// the phase change of the exact oscillation during the step, in radians.
template <class V>
void expect_pade(const char* name) {
    using S = ScalarOf<V>;
    const Method& method = method_named(name);
    const double n0 = default_parameters<Fiber>()[0], alpha = default_parameters<Fiber>()[1], omega = n0 * alpha;
    for (const double phase : {0.5, 4.0, 8.0, 12.0}) {
        SCOPED_TRACE(phase);
        auto stepper = SpaceStepper<V>::template for_space<Fiber>(method, false);
        const State<double> start{{0.4, -0.3, 0.1, 0.2, 0.25, 1.2, 0}};
        State<V> packet_start;
        for (int k = 0; k < 7; ++k) packet_start.y[k] = V(S(start.y[k]));
        const double h = phase / omega;
        stepper.begin(packet_start, V(S(h)));
        stepper.step();
        EXPECT_TRUE(to_bits(stepper.state.solved) & 1);
        const std::complex<double> factor = pade(stages_of(method), {0, phase});
        const auto component = [&](int k) { return double(get_lane(stepper.state.end.y[k], lane_count<V> - 1)); };
        const double rounding = 1e3 * double(machine_epsilon<S>);
        for (int k = 0; k < 2; ++k) {
            // The complex number q + i p/ω rotates clockwise, so that a step multiplies it by the complex conjugate of
            // the approximant.
            const std::complex<double> amplitude(start.y[k], start.y[3 + k] / omega);
            const std::complex<double> end = std::conj(factor) * amplitude;
            EXPECT_NEAR(component(k), end.real(), rounding);
            EXPECT_NEAR(component(3 + k), omega * end.imag(), rounding);
        }
        EXPECT_NEAR(component(2), start.y[2] + h * start.y[5], rounding * h);
    }
}

TEST(NewtonStages, LongStepsOfAnOscillatorMatchThePadeApproximant) {
    for (const char* method : {"midpoint", "gauss4", "gauss6", "gauss8", "gauss12", "gauss16"}) {
        SCOPED_TRACE(method);
        expect_pade<double>(method);
        expect_pade<PacketDouble>(method);
        expect_pade<PacketFloat>(method);
    }
}

/// Result of one step in the fisheye.
struct LongStep {
    bool solved;
    bool used_newton;           ///< True if fixed-point iteration did not converge and Newton's method was used.
    std::array<double, 6> end;  ///< Position and momentum at the end.
};
LongStep long_step(const Method& method, double h) {
    auto stepper = SpaceStepper<double>::for_space<Fisheye>(method, false);
    stepper.begin(state_of<double>(bent_ray<Fisheye>()), h);
    stepper.step();
    const bool used_newton = double(stepper.state.lane_iterations) > Convergence<double>::max_iterations;
    LongStep result{stepper.state.solved, used_newton, {}};
    std::copy(stepper.state.end.y, stepper.state.end.y + 6, result.end.begin());
    return result;
}

// The step length increases by factors of 1.002. The end of the step must change by a small amount each time; a jump
// would reveal a solution on another branch. Only gauss4 has steps in this test that Newton's method solves and
// fixed-point iteration does not.
TEST(NewtonStages, SolutionIsContinuousInTheStepLength) {
    bool newton_was_used = false;
    for (const char* name : {"gauss4", "gauss8", "gauss16"}) {
        SCOPED_TRACE(name);
        const Method& method = method_named(name);
        constexpr double ratio = 1.002;
        LongStep previous = long_step(method, 0.01);
        for (double h = 0.01 * ratio; h < 10; h *= ratio) {
            const LongStep next = long_step(method, h);
            if (!next.solved) break;
            newton_was_used = newton_was_used || next.used_newton;
            // The step length changes by less than (ratio − 1) h. The end of the step moves by this change times the
            // velocity of the ray, which is below 20.
            for (int k = 0; k < 6; ++k)
                EXPECT_NEAR(next.end[k], previous.end[k], 20 * (ratio - 1) * h) << "h = " << h << ", component " << k;
            previous = next;
        }
    }
    EXPECT_TRUE(newton_was_used);
}

}  // namespace
}  // namespace kagero::test

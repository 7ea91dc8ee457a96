// Tests of the reverse sweep along a ray (kernels/adjoint/sweep.h). The adjoints of the sweep are compared with
// differences of neighbouring rays. Bounds on the rounding errors of programs are compared with sums that are computed
// by hand.
#include "tests/kernels/steps.h"

#include "kernels/adjoint/rounding.h"
#include "kernels/adjoint/sweep.h"
#include "kernels/trace/packets.h"

#include <numbers>
#include <string_view>

namespace kagero::test {
namespace {

using V = PacketDouble;
constexpr int last_lane = lane_count<V> - 1;

/// The states of a ray at the ends of its steps.
struct Path {
    std::vector<State<V>> states;
    std::vector<V> parameters;  ///< λ of each state
    Vec3<V> velocity{};         ///< velocity at the end
};

/// Returns the sensitivity of a ray end on a plane with the given normal. In this test the two film coordinates are the
/// coordinates y and z of the end.
EndSensitivity<V> sensitivity_on_plane(const Vec3<V>& normal) {
    const V zero(0.0), one(1.0);
    return {normal, {{zero, one, zero}, {zero, zero, one}}, {{zero, zero, zero}, {zero, zero, zero}}};
}

/// Returns the derivatives of the two film coordinates with respect to position and momentum at the start of a path, in
/// the last lane.
std::array<std::array<double, 6>, 2> adjoints_at_start(const SpaceKernel<V>& kernel, const double* parameters,
                                                       const Path& path, const EndSensitivity<V>& end) {
    SystemStorage system;
    kernel.construct(system, parameters);
    const SweptSystem<V> swept_system{kernel, system};
    const RoundingCounts counts{};
    Sweep<V> sweep;
    sweep.state = path.states.back();
    begin_sweep(swept_system, end, sweep);
    for (std::size_t i = path.states.size() - 1; i-- > 0;)
        sweep_step(swept_system, path.states[i], path.parameters[i + 1] - path.parameters[i], counts, sweep);
    std::array<std::array<double, 6>, 2> rows;
    for (int r = 0; r < 2; ++r)
        for (int k = 0; k < 6; ++k) rows[r][k] = get_lane(sweep.rows[r][k], last_lane);
    return rows;
}

/// Integrates the path of a ray with the given number of steps.
template <class H>
Path path_from(const State<V>& start, bool rescaled, int steps) {
    auto stepper = SpaceStepper<V>::template for_space<H>(method_named("gauss8"), rescaled);
    stepper.begin(start, V(path_length<H> / steps));
    Path path{{start}, {V(0.0)}};
    for (int i = 0; i < steps; ++i) {
        stepper.advance(1);
        path.states.push_back(stepper.state.end);
        path.parameters.push_back(stepper.state.end.parameter);
    }
    path.velocity = stepper.state.end.velocity;
    return path;
}

/// Returns the greatest error of the adjoints at the start of a path, relative to the greatest adjoint. The reference
/// is the central difference of rays whose starts differ by ±1e-5 in one component. The ends of these rays are shifted
/// along the velocity to the plane through the end of the path.
template <class H>
double adjoint_error(bool rescaled, int steps) {
    const State<V> start = state_of<V>(bent_ray<H>(0, true));
    const Path path = path_from<H>(start, rescaled, steps);
    const Vec3<V> velocity = path.velocity;
    const auto rows =
        adjoints_at_start(space_kernel<H, V>(rescaled), default_parameters<H>().data(), path,
                          sensitivity_on_plane(velocity));
    const auto end_of_shifted_ray = [&](int k, double shift) {
        State<V> shifted = start;
        shifted.y[k] = shifted.y[k] + V(shift);
        Vec3<V> q = path_from<H>(shifted, rescaled, steps).states.back().q();
        const Vec3<V> difference = retreat(q, V(1.0), path.states.back().q());
        q = retreat(q, dot(difference, velocity) / dot(velocity, velocity), velocity);
        return std::array{get_lane(q.y, last_lane), get_lane(q.z, last_lane)};
    };
    double worst = 0, greatest = 0;
    for (int k = 0; k < 6; ++k) {
        constexpr double shift = 1e-5;
        const auto plus = end_of_shifted_ray(k, shift), minus = end_of_shifted_ray(k, -shift);
        for (int r = 0; r < 2; ++r) {
            const double difference_quotient = (plus[r] - minus[r]) / (2 * shift);
            EXPECT_TRUE(std::isfinite(rows[r][k]) && std::isfinite(difference_quotient));
            worst = std::max(worst, std::abs(rows[r][k] - difference_quotient));
            greatest = std::max(greatest, std::abs(difference_quotient));
        }
    }
    return worst / greatest;
}

template <class H>
class Adjoints : public ::testing::Test {};
TYPED_TEST_SUITE(Adjoints, AllHamiltonians, HamiltonianName);

// The error has order 4, so that four times as many steps reduce it by a factor of 256. The test requires a factor of
// 50. Differences of rays have errors of up to 1e-7.
TYPED_TEST(Adjoints, MatchDifferencesOfRays) {
    using H = TypeParam;
    for (const bool rescaled : rescalings<H>()) {
        const double coarse = adjoint_error<H>(rescaled, 32), fine = adjoint_error<H>(rescaled, 128);
        EXPECT_LE(fine, std::max(0.02 * coarse, 1e-7)) << (rescaled ? "rescaled" : "");
        EXPECT_LE(fine, 1e-4);
    }
}

// The surface of a Luneburg lens is a discontinuity. Parallel rays meet in one point of this surface, so that y and z
// of the end do not depend on the position of the start.
TYPED_TEST(Adjoints, AreCorrectAcrossADiscontinuity) {
    using H = TypeParam;
    if constexpr (std::string_view(H::name) != "luneburg") {
        GTEST_SKIP() << "This test uses the closed form of rays in a Luneburg lens.";
    } else {
        constexpr double y = 0.6, x = -0.8, outside_length = 1.2;
        constexpr int inside_steps = 16;
        const auto state = [](double qx, double qy, double px, double py) {
            return State<V>{{V(qx), V(qy), V(0.0), V(px), V(py), V(0.0), V(0.0)}};
        };
        Path path{{state(x - outside_length, y, 1, 0), state(x, y, 1, 0)}, {V(0.0), V(outside_length)}};
        for (int i = 1; i <= inside_steps; ++i) {
            const double t = std::numbers::pi / 2 * i / inside_steps, c = std::cos(t), s = std::sin(t);
            path.states.push_back(state(x * c + s, y * c, c - x * s, -y * s));
            path.parameters.push_back(V(outside_length + t));
        }
        const auto rows = adjoints_at_start(space_kernel<H, V>(false), default_parameters<H>().data(), path,
                                            sensitivity_on_plane({V(1.0), V(0.0), V(0.0)}));
        const double expected[2][6] = {{0, 0, 0, -y / x, 1, 0}, {0, 0, 0, 0, 0, 1}};
        for (int r = 0; r < 2; ++r)
            for (int k = 0; k < 6; ++k) EXPECT_NEAR(rows[r][k], expected[r][k], 1e-5) << r << k;
    }
}

// The program computes 1/(x y) at x y = 20. The unit in the first place is 16 for 20, and 1/32 for 1/20. The norm of
// the two seeds is 1, so that the reciprocal has the adjoint 1, and the product has the adjoint 1/400. The rounding
// bound of the reciprocal in operation_table.h is 4, that of the product is 1.
TEST(Roundings, AreSummedOverAllOperations) {
    Tape t;
    const int x = t.input(0), y = t.input(1);
    const auto program = kagero::detail::extract_untrimmed<1>(t, std::array{t.recip(t.mul(x, y))});
    const double inputs[] = {4, 5}, seeds[] = {0.6, 0.8};
    const double sum = rounding_bound_of<double>(
        ProgramWithUniforms<double>{
            {program.nodes, program.slot, program.outputs.data(), program.size}, nullptr},
        inputs, seeds, 1);
    EXPECT_NEAR(sum, 4 / 32.0 + 16 / 400.0, 1e-12);
}

// The program computes x y − 19 = 1. Without fused operations, the product 20 is rounded separately: its unit in the
// first place is 16.
TEST(Roundings, IncludeProductsThatAreNotFused) {
    Tape t;
    const auto program =
        kagero::detail::extract_untrimmed<1>(t, std::array{t.sub(t.mul(t.input(0), t.input(1)), t.input(2))});
    const double inputs[] = {4, 5, 19}, seeds[] = {0.6, 0.8};
    const double sum = rounding_bound_of<double>(
        ProgramWithUniforms<double>{
            {program.nodes, program.slot, program.outputs.data(), program.size}, nullptr},
        inputs, seeds, 1);
#if defined(__FMA__)
    EXPECT_EQ(sum, 1);
#else
    EXPECT_EQ(sum, 1 + 16);
#endif
}

}  // namespace
}  // namespace kagero::test

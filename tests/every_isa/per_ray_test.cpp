// Tests of the vectorizations in kernels/comparison. Their steps are compared with steps of the scalar strategy.
//
// With the stages of a Gauss method in the lanes, a step agrees with the scalar step bit for bit, because sums are
// computed in the same order. With the components of the gradient in the lanes, a step agrees only to rounding, because
// the gradient is computed in forward mode instead of reverse mode.
#include "tests/support/greatest.h"
#include "tests/kernels/steps.h"

#include "kernels/comparison/compared.h"

namespace kagero::test {
namespace {

using ComparedHamiltonians = detail::AllButFirst<void
#define KAGERO_HAMILTONIAN(TYPE) , hamiltonians::TYPE
#include "compared.inc"
#undef KAGERO_HAMILTONIAN
                                                 >::Types;

template <class H>
class ComparedVectorizations : public ::testing::Test {};
TYPED_TEST_SUITE(ComparedVectorizations, ComparedHamiltonians, HamiltonianName);

/// Returns the greatest difference of state, velocity, λ and H at the ends of two steps, relative to 1 + |value|.
double difference(const StepperState<double>& a, const StepperState<double>& b) {
    double worst = 0;
    const auto compare = [&](double x, double y) {
        worst = greatest(worst, std::abs(x - y) / (1 + std::abs(y)));
    };
    for (int k = 0; k < 7; ++k) compare(a.end.y[k], b.end.y[k]);
    compare(a.end.velocity.x, b.end.velocity.x);
    compare(a.end.velocity.y, b.end.velocity.y);
    compare(a.end.velocity.z, b.end.velocity.z);
    compare(a.end.parameter, b.end.parameter);
    compare(a.energy, b.energy);
    return worst;
}

/// Integrates six random rays by 12 steps of every method that the vectorization supports, and by the same scalar
/// steps. Calls check(state, scalar state, number of steps, method) for each ray and method.
template <class H, class Vectorization, class Check>
void compare_with_scalar(const Check& check) {
    const auto rays = random_rays<H>(6, 23);
    int supported = 0;
    for_all_methods<H>([&](const Method& method, bool rescaled) {
        const auto& kernel = compared_kernel<Vectorization, H>(rescaled);
        if (kernel.refusal[static_cast<int>(method.kind)]) return;
        ++supported;
        const double h = path_length<H> / 64;
        for (const RayStart& ray : rays) {
            auto vectorized = SpaceStepper<double>::with_kernel(method, kernel, default_parameters<H>().data());
            auto scalar = SpaceStepper<double>::template for_space<H>(method, rescaled);
            vectorized.begin(state_of<double>(ray), h);
            scalar.begin(state_of<double>(ray), h);
            vectorized.advance(12);
            scalar.advance(12);
            EXPECT_EQ(vectorized.state.solved, scalar.state.solved);
            check(vectorized.state, scalar.state, 12, method);
        }
    });
    EXPECT_GT(supported, 0);
}

TYPED_TEST(ComparedVectorizations, StagesInLanesMatchScalarBitForBit) {
    compare_with_scalar<TypeParam, PerRayStages>([](const auto& state, const auto& scalar, int, const Method&) {
        EXPECT_EQ(difference(state, scalar), 0);
        EXPECT_EQ(state.gradients, scalar.gradients);
    });
}

TYPED_TEST(ComparedVectorizations, GradientInLanesMatchesScalarToRounding) {
    compare_with_scalar<TypeParam, PerRayGradient>(
        [](const auto& state, const auto& scalar, int steps, const Method& method) {
            EXPECT_LE(difference(state, scalar), 100 * steps * stages_of(method) * machine_epsilon<double>);
        });
}

TYPED_TEST(ComparedVectorizations, CompilerVectorizedStepsMatchScalarBitForBit) {
    compare_with_scalar<TypeParam, AutoVectorized>(
        [](const auto& state, const auto& scalar, int, const Method&) { EXPECT_EQ(difference(state, scalar), 0); });
}

/// Expects that each lane of a packet ends with the same bits as the scalar steps of its ray.
template <class H, class Vectorization>
void expect_lanes_match_scalars() {
    using V = typename Vectorization::Value;
    using S = ScalarOf<V>;
    const auto rays = random_rays<H>(lane_count<V>, 29);
    int supported = 0;
    for_all_methods<H>([&](const Method& method, bool rescaled) {
        const auto& kernel = compared_kernel<Vectorization, H>(rescaled);
        if (kernel.refusal[static_cast<int>(method.kind)]) return;
        ++supported;
        const S h = S(path_length<H> / 64);
        State<V> starts;
        for (int i = 0; i < lane_count<V>; ++i)
            for (int k = 0; k < 7; ++k) set_lane(starts.y[k], i, state_of<S>(rays[static_cast<std::size_t>(i)]).y[k]);
        auto packet = SpaceStepper<V>::with_kernel(method, kernel, default_parameters<H>().data());
        packet.begin(starts, V(h));
        packet.advance(8);
        for (int i = 0; i < lane_count<V>; ++i) {
            auto scalar = SpaceStepper<S>::template for_space<H>(method, rescaled);
            scalar.begin(state_of<S>(rays[static_cast<std::size_t>(i)]), h);
            scalar.advance(8);
            for (int k = 0; k < 7; ++k)
                EXPECT_EQ(get_lane(packet.state.end.y[k], i), scalar.state.end.y[k]) << "lane " << i;
        }
    });
    EXPECT_GT(supported, 0);
}
TYPED_TEST(ComparedVectorizations, PacketsOfOtherWidthsMatchScalarBitForBit) {
    expect_lanes_match_scalars<TypeParam, SmallerAlternativeDouble>();
    expect_lanes_match_scalars<TypeParam, LargerAlternativeDouble>();
    expect_lanes_match_scalars<TypeParam, SmallerAlternativeFloat>();
    expect_lanes_match_scalars<TypeParam, LargerAlternativeFloat>();
}

}  // namespace
}  // namespace kagero::test

// One ray per vector: steps with the stages of a Gauss method in the lanes are those of the scalar strategy to the last
// bit, for the sums run in the same order; with the components of the gradient in the lanes, and forward instead of
// reverse, they agree to rounding.
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
class PerRay : public ::testing::Test {};
TYPED_TEST_SUITE(PerRay, ComparedHamiltonians, HamiltonianName);

/// Greatest difference of state, velocity and λ after some steps, relative to 1 + |value|.
double difference(const StepperState<double>& a, const StepperState<double>& b) {
    double worst = 0;
    const auto look = [&](double x, double y) {
        worst = greatest(worst, std::abs(x - y) / (1 + std::abs(y)));
    };
    for (int k = 0; k < 7; ++k) look(a.end.y[k], b.end.y[k]);
    look(a.end.velocity.x, b.end.velocity.x), look(a.end.velocity.y, b.end.velocity.y),
        look(a.end.velocity.z, b.end.velocity.z);
    look(a.end.parameter, b.end.parameter), look(a.energy, b.energy);
    return worst;
}

/// Calls check(per ray, scalar, steps taken, method) for every method that both serve.
template <class H, class Way, class Check>
void compare_with_scalar(const Check& check) {
    const auto rays = random_rays<H>(6, 23);
    int served = 0;
    for_all_methods<H>([&](const Method& method, bool rescaled) {
        const auto& kernel = compared_kernel<Way, H>(rescaled);
        if (kernel.refusal[static_cast<int>(method.kind)]) return;
        ++served;
        const double h = path_length<H> / 64;
        for (const RayStart& ray : rays) {
            auto one = Steps<double>::with(method, kernel, default_parameters<H>().data());
            auto other = Steps<double>::template in<H>(method, rescaled);
            one.begin(state_of<double>(ray), h), other.begin(state_of<double>(ray), h);
            one.advance(12), other.advance(12);
            EXPECT_EQ(one.flow.solved, other.flow.solved);
            check(one.flow, other.flow, 12, method);
        }
    });
    EXPECT_GT(served, 0);
}

TYPED_TEST(PerRay, StagesAreScalarToTheLastBit) {
    compare_with_scalar<TypeParam, PerRayStages>([](const auto& one, const auto& other, int, const Method&) {
        EXPECT_EQ(difference(one, other), 0);
        EXPECT_EQ(one.gradients, other.gradients);
    });
}

TYPED_TEST(PerRay, GradientsAgreeToRounding) {
    compare_with_scalar<TypeParam, PerRayGradient>(
        [](const auto& one, const auto& other, int steps, const Method& method) {
            EXPECT_LE(difference(one, other), 100 * steps * stages_of(method) * machine_epsilon<double>);
        });
}

TYPED_TEST(PerRay, WhatTheCompilerVectorizesIsScalarToTheLastBit) {
    compare_with_scalar<TypeParam, AutoVectorized>(
        [](const auto& one, const auto& other, int, const Method&) { EXPECT_EQ(difference(one, other), 0); });
}

template <class H, class Way>
void expect_lanes_are_scalars() {
    using V = typename Way::Value;
    using S = ScalarOf<V>;
    const auto rays = random_rays<H>(lane_count<V>, 29);
    int served = 0;
    for_all_methods<H>([&](const Method& method, bool rescaled) {
        const auto& kernel = compared_kernel<Way, H>(rescaled);
        if (kernel.refusal[static_cast<int>(method.kind)]) return;
        ++served;
        const S h = S(path_length<H> / 64);
        State<V> starts;
        for (int i = 0; i < lane_count<V>; ++i)
            for (int k = 0; k < 7; ++k) set_lane(starts.y[k], i, state_of<S>(rays[static_cast<std::size_t>(i)]).y[k]);
        auto together = Steps<V>::with(method, kernel, default_parameters<H>().data());
        together.begin(starts, V(h));
        together.advance(8);
        for (int i = 0; i < lane_count<V>; ++i) {
            auto alone = Steps<S>::template in<H>(method, rescaled);
            alone.begin(state_of<S>(rays[static_cast<std::size_t>(i)]), h);
            alone.advance(8);
            for (int k = 0; k < 7; ++k)
                EXPECT_EQ(get_lane(together.flow.end.y[k], i), alone.flow.end.y[k]) << "lane " << i;
        }
    });
    EXPECT_GT(served, 0);
}
TYPED_TEST(PerRay, OtherWidthsAreScalars) {
    expect_lanes_are_scalars<TypeParam, FewDouble>();
    expect_lanes_are_scalars<TypeParam, ManyDouble>();
    expect_lanes_are_scalars<TypeParam, FewFloat>();
    expect_lanes_are_scalars<TypeParam, ManyFloat>();
}

}  // namespace
}  // namespace kagero::test

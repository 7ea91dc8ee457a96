// Time rescaling must change only the independent variable, not the ray itself. Integration of Ω·(H − H0) up to τ is
// compared with integration of H up to the corresponding λ.
#include "tests/kernels/steps.h"

namespace kagero::test {
namespace {

template <class H>
class Rescaling : public ::testing::Test {};
TYPED_TEST_SUITE(Rescaling, AllHamiltonians, HamiltonianName);

/// Returns the start of a bent ray, with H = H0 to the rounding of double.
template <class H>
RayStart bent_ray_on_level(const Method& method, int ray_index) {
    auto stepper = SpaceStepper<double>::for_space<H>(method, false);
    const RayStart rounded = bent_ray<H>(ray_index);
    stepper.begin(state_of<double>(rounded), 0.0);
    const Vec3<double>& v = stepper.state.start.velocity;
    RayStart ray;
    EXPECT_EQ(start_ray<H>(rounded.q, {v.x, v.y, v.z}, ray), Failure::none);
    return ray;
}

// The tolerance allows 30 rounding errors of double in each of the n steps with rescaling and 4 n steps without it.
TYPED_TEST(Rescaling, ReachesTheSameStateAtTheSameParameter) {
    using H = TypeParam;
    if constexpr (!Rescalable<H>) {
        GTEST_SKIP() << H::name << " has no time rescaling.";
    } else {
        constexpr int n = 64;
        for (const Method& method : methods_for<H>(true)) {
            if (method.info.order < 8) continue;  // the truncation error must be below rounding errors
            SCOPED_TRACE(method.info.name);
            for (int ray_index = 0; ray_index < bent_ray_count; ++ray_index) {
                const RayStart ray = bent_ray_on_level<H>(method, ray_index);
                auto rescaled = SpaceStepper<double>::for_space<H>(method, true);
                auto unrescaled = SpaceStepper<double>::for_space<H>(method, false);
                rescaled.begin(state_of<double>(ray), path_length<H> / 2 / n);
                rescaled.advance(n);
                unrescaled.begin(state_of<double>(ray), rescaled.state.end.parameter / (4 * n));
                unrescaled.advance(4 * n);
                for (int k = 0; k < 6; ++k) {
                    const double y = unrescaled.state.end.y[k];
                    EXPECT_NEAR(rescaled.state.end.y[k], y, 30 * 5 * n * machine_epsilon<double> * (1 + std::abs(y)))
                        << k;
                }
            }
        }
    }
}

}  // namespace
}  // namespace kagero::test

// Time rescaling changes the parameter of a ray, but not the ray itself. The state at τ with Ω·(H − H0) is compared
// with the state at the corresponding λ with H.
#include "tests/kernels/steps.h"

namespace kagero::test {
namespace {

template <class H>
class Rescaling : public ::testing::Test {};
TYPED_TEST_SUITE(Rescaling, AllHamiltonians, HamiltonianName);

/// Returns a bent ray with H = H0 to the rounding of double.
template <class H>
RayStart null_ray(const Method& method, int which) {
    auto steps = Steps<double>::in<H>(method, false);
    const RayStart approximate = bent_ray<H>(which);
    steps.begin(state_of<double>(approximate), 0.0);
    const Vec3<double>& v = steps.state.start.velocity;
    RayStart ray;
    EXPECT_EQ(start_ray<H>(approximate.q, {v.x, v.y, v.z}, ray), Failure::none);
    return ray;
}

// The tolerance allows 30 rounding errors of double in each of the 5 n steps.
TYPED_TEST(Rescaling, ReachesTheSameStateAtTheSameParameter) {
    using H = TypeParam;
    if constexpr (!Rescalable<H>) {
        GTEST_SKIP() << H::name << " has no time rescaling.";
    } else {
        constexpr int n = 64;
        for (const Method& method : methods_for<H>(true)) {
            if (method.info.order < 8) continue;  // only higher orders have errors below rounding with these steps
            SCOPED_TRACE(method.info.name);
            for (int which = 0; which < bent_ray_count; ++which) {
                const RayStart ray = null_ray<H>(method, which);
                auto transformed = Steps<double>::in<H>(method, true), plain = Steps<double>::in<H>(method, false);
                transformed.begin(state_of<double>(ray), path_length<H> / 2 / n);
                transformed.advance(n);
                plain.begin(state_of<double>(ray), transformed.state.end.parameter / (4 * n));
                plain.advance(4 * n);
                for (int k = 0; k < 6; ++k) {
                    const double y = plain.state.end.y[k];
                    EXPECT_NEAR(transformed.state.end.y[k], y, 30 * 5 * n * machine_epsilon<double> * (1 + std::abs(y)))
                        << k;
                }
            }
        }
    }
}

}  // namespace
}  // namespace kagero::test

// A time transformation changes the pace, not the ray: what is reached at τ with Ω·(H − H0) is reached at λ with H.
#include "tests/kernels/steps.h"

namespace kagero::test {
namespace {

template <class H>
class Rescaling : public ::testing::Test {};
TYPED_TEST_SUITE(Rescaling, AllHamiltonians, HamiltonianName);

/// A bent ray with H = H0 to the rounding of double.
template <class H>
RayStart null_ray(const Method& method, int which) {
    auto steps = Steps<double>::in<H>(method, false);
    const RayStart rough = bent_ray<H>(which);
    steps.begin(state_of<double>(rough), 0.0);
    const Vec3<double>& v = steps.flow.start.velocity;
    RayStart ray;
    EXPECT_EQ(start_ray<H>(rough.q, {v.x, v.y, v.z}, ray), Failure::none);
    return ray;
}

TYPED_TEST(Rescaling, ReachesTheSamePlacesAtTheParameterItReports) {
    using H = TypeParam;
    if constexpr (!Rescalable<H>) {
        GTEST_SKIP() << H::name << " declares no time transformation";
    } else {
        constexpr int n = 64;
        for (const Method& method : methods_for<H>(true)) {
            if (method.info.order < 8) continue;  // whose own error at these steps is below rounding
            SCOPED_TRACE(method.info.name);
            for (int which = 0; which < bent_rays; ++which) {
                const RayStart ray = null_ray<H>(method, which);
                auto transformed = Steps<double>::in<H>(method, true), plain = Steps<double>::in<H>(method, false);
                transformed.begin(state_of<double>(ray), path_length<H> / 2 / n);
                transformed.advance(n);
                plain.begin(state_of<double>(ray), transformed.flow.end.parameter / (4 * n));
                plain.advance(4 * n);
                for (int k = 0; k < 6; ++k) {
                    const double y = plain.flow.end.y[k];
                    EXPECT_NEAR(transformed.flow.end.y[k], y, 30 * 5 * n * machine_epsilon<double> * (1 + std::abs(y)))
                        << k;
                }
            }
        }
    }
}

}  // namespace
}  // namespace kagero::test

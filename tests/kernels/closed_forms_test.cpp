// One step of eq. (9) against closed forms: its implicit half is a quadratic equation for eq. (16) and for eq. (17).
// Where that has no real root, or only one beyond a fold, which no ray that starts with τ = 0 can reach, the step must
// say that it is unsolved.
#include "tests/kernels/steps.h"

#include "kernels/trace/packets.h"

#include <algorithm>

namespace kagero::test {
namespace {

/// The solution, and how far it is from a fold: the smallest factor of the Jacobian's determinant, at most zero where
/// there is none.
struct Solution {
    double y[6];
    double margin;
};

using hamiltonians::Mirage, hamiltonians::Schwarzschild;

/// Eq. (16), f = r_g/r: u = p_t + n·p solves u' = u − a u'² with a = τ f/(2r); the rest of p' is linear in it.
Solution closed_form(const Schwarzschild*, const RayStart& ray, double tau) {
    const double rg = default_parameters<Schwarzschild>()[0];
    const Vec3<double> q{ray.q[0], ray.q[1], ray.q[2]}, p{ray.p[0], ray.p[1], ray.p[2]};
    const double r = norm(q), f = rg / r, a = tau * f / (2 * r);
    const Vec3<double> n = (1 / r) * q;
    const double u = ray.pt + dot(n, p), square = 1 + 4 * a * u;
    if (!(square > 0)) return {{}, square};
    const double root = std::sqrt(square), next = 2 * u / (1 + root), across = 1 - tau * f * next / r;
    const Vec3<double> momentum = (next - ray.pt) * n + (1 / across) * (p - dot(n, p) * n);
    const Vec3<double> position = q + tau * (momentum - (f * next) * n);
    return {{position.x, position.y, position.z, momentum.x, momentum.y, momentum.z}, std::min(root, across)};
}

/// Eq. (17), g = ∇n: s = |p'|² solves τ²g²s²/4 − A s + |p|² = 0 with A = 1 + τ p·g.
Solution closed_form(const Mirage*, const RayStart& ray, double tau) {
    const auto k = make_parameters<Mirage>(default_parameters<Mirage>().data());
    const Vec3<double> q{ray.q[0], ray.q[1], ray.q[2]}, p{ray.p[0], ray.p[1], ray.p[2]};
    const Vec3<double> g{-k.ripple * k.wavenumber * std::sin(k.wavenumber * q.x), 0, -3 * k.n3 * q.z * q.z};
    const double a = 1 + tau * dot(p, g), least = std::abs(tau) * norm(g) * norm(p);
    if (!(a > least)) return {{}, a - least};
    const double root = std::sqrt((a - least) * (a + least)), s = 2 * dot(p, p) / (a + root);
    const Vec3<double> momentum = p - (0.5 * tau * s) * g, position = q + (tau * Mirage::n(k, q)) * momentum;
    return {{position.x, position.y, position.z, momentum.x, momentum.y, momentum.z}, root};
}

template <class H>
class ClosedForms : public ::testing::Test {};
using HaveClosedForms = ::testing::Types<Mirage, Schwarzschild>;
TYPED_TEST_SUITE(ClosedForms, HaveClosedForms, HamiltonianName);

template <class H, class V>
void expect_closed_form(double longest) {
    Random random(31);
    auto steps = Steps<V>::template in<H>(method_named("euler"), false);
    int with = 0, without = 0;
    for (const RayStart& ray : random_rays<H>(2000, 32)) {
        const double tau = random(-longest, longest);
        const Solution expected = closed_form(static_cast<const H*>(nullptr), ray, tau);
        steps.begin(state_of<V>(ray), V(tau));
        steps.step();
        const bool solved = to_bits(steps.flow.solved) & 1;
        // Near a fold rounding decides, and iterations may leave the basin of a root: to give up is allowed there, a
        // wrong root nowhere.
        constexpr double at_a_fold = 1e-6, near_a_fold = 0.5;
        if (expected.margin > at_a_fold) {
            EXPECT_TRUE(solved || expected.margin < near_a_fold) << "margin " << expected.margin;
            if (!solved) continue;
            for (int k = 0; k < 6; ++k) {
                const double size =
                    (1 + std::abs(expected.y[k])) * (1 + std::abs(tau)) / (expected.margin * expected.margin);
                EXPECT_NEAR(get_lane(steps.flow.end.y[k], 0), expected.y[k], 100 * machine_epsilon<double> * size)
                    << "component " << k;
            }
            ++with;
        } else if (expected.margin < -at_a_fold) {
            EXPECT_FALSE(solved) << "a root beyond the fold, at τ = " << tau << ", margin " << expected.margin;
            ++without;
        }
    }
    EXPECT_GT(with, 500);
    EXPECT_GT(without, 20);
}
TYPED_TEST(ClosedForms, OfOneStepInDouble) { expect_closed_form<TypeParam, double>(40 * TypeParam::step); }
TYPED_TEST(ClosedForms, OfOneStepInPackets) { expect_closed_form<TypeParam, PacketDouble>(40 * TypeParam::step); }

}  // namespace
}  // namespace kagero::test

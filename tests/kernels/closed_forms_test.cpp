// Compares a step of semi-implicit Euler, eq. (9) of Satoh (2003), with a closed form. With H of eq. (16) or eq. (17),
// the implicit half of the step is a quadratic equation. As |τ| grows from 0, the root moves continuously from the
// start of the step, until it may meet another root at a fold. Beyond the fold the equation has no real root, or only
// one on another branch, and the step must be reported as unsolved.
#include "tests/kernels/steps.h"

#include "kernels/trace/packets.h"

#include <algorithm>

namespace kagero::test {
namespace {

/// The exact result of a step.
struct Solution {
    double y[6];    ///< Position and momentum at the end.
    double margin;  ///< Least factor of the determinant of the Jacobian: 0 at a fold, ≤ 0 if there is no solution.
};

using hamiltonians::Mirage, hamiltonians::Schwarzschild;

/// Returns the result of a step with eq. (16). The first argument only selects the overload. Primes denote values at
/// the end of the step. With f = r_g/r, n = q/r and a = τ f/(2r), u = p_t + n·p satisfies u' = u − a u'². The
/// components of p' normal to n satisfy linear equations.
Solution closed_form(const Schwarzschild*, const RayStart& ray, double tau) {
    const double rg = default_parameters<Schwarzschild>()[0];
    const Vec3<double> q{ray.q[0], ray.q[1], ray.q[2]}, p{ray.p[0], ray.p[1], ray.p[2]};
    const double r = norm(q), f = rg / r, a = tau * f / (2 * r);
    const Vec3<double> n = (1 / r) * q;
    const double u = ray.pt + dot(n, p), discriminant = 1 + 4 * a * u;
    if (!(discriminant > 0)) return {{}, discriminant};
    const double root = std::sqrt(discriminant), new_u = 2 * u / (1 + root), transverse = 1 - tau * f * new_u / r;
    const Vec3<double> momentum = (new_u - ray.pt) * n + (1 / transverse) * (p - dot(n, p) * n);
    const Vec3<double> position = q + tau * (momentum - (f * new_u) * n);
    return {{position.x, position.y, position.z, momentum.x, momentum.y, momentum.z}, std::min(root, transverse)};
}

/// Returns the result of a step with eq. (17), H = n |p|²/2. With g = ∇n and A = 1 + τ p·g, s = |p'|² satisfies
/// τ²g²s²/4 − A s + |p|² = 0. The roots coincide at A = |τ| |g| |p|.
Solution closed_form(const Mirage*, const RayStart& ray, double tau) {
    const auto k = make_parameters<Mirage>(default_parameters<Mirage>().data());
    const Vec3<double> q{ray.q[0], ray.q[1], ray.q[2]}, p{ray.p[0], ray.p[1], ray.p[2]};
    const Vec3<double> g{-k.ripple * k.wavenumber * std::sin(k.wavenumber * q.x), 0, -3 * k.n3 * q.z * q.z};
    const double a = 1 + tau * dot(p, g), a_at_fold = std::abs(tau) * norm(g) * norm(p);
    if (!(a > a_at_fold)) return {{}, a - a_at_fold};
    const double root = std::sqrt((a - a_at_fold) * (a + a_at_fold)), s = 2 * dot(p, p) / (a + root);
    const Vec3<double> momentum = p - (0.5 * tau * s) * g, position = q + (tau * Mirage::n(k, q)) * momentum;
    return {{position.x, position.y, position.z, momentum.x, momentum.y, momentum.z}, root};
}

template <class H>
class EulerStep : public ::testing::Test {};
using SpacesWithClosedForms = ::testing::Types<Mirage, Schwarzschild>;
TYPED_TEST_SUITE(EulerStep, SpacesWithClosedForms, HamiltonianName);

/// Compares steps of random rays with random τ in [−greatest_tau, greatest_tau] with the closed form.
template <class H, class V>
void expect_closed_form(double greatest_tau) {
    Random random(31);
    auto stepper = SpaceStepper<V>::template for_space<H>(method_named("euler"), false);
    int solvable = 0, unsolvable = 0;
    for (const RayStart& ray : random_rays<H>(2000, 32)) {
        const double tau = random(-greatest_tau, greatest_tau);
        const Solution expected = closed_form(static_cast<const H*>(nullptr), ray, tau);
        stepper.begin(state_of<V>(ray), V(tau));
        stepper.step();
        const bool solved = to_bits(stepper.state.solved) & 1;
        // If |margin| is at most `fold_margin`, the result depends on rounding and is not tested. If the margin is
        // below `divergence_margin`, the iteration may diverge, so that the step may be unsolved.
        constexpr double fold_margin = 1e-6, divergence_margin = 0.5;
        if (expected.margin > fold_margin) {
            EXPECT_TRUE(solved || expected.margin < divergence_margin) << "margin " << expected.margin;
            if (!solved) continue;
            for (int k = 0; k < 6; ++k) {
                const double size =
                    (1 + std::abs(expected.y[k])) * (1 + std::abs(tau)) / (expected.margin * expected.margin);
                EXPECT_NEAR(get_lane(stepper.state.end.y[k], 0), expected.y[k], 100 * machine_epsilon<double> * size)
                    << "component " << k;
            }
            ++solvable;
        } else if (expected.margin < -fold_margin) {
            EXPECT_FALSE(solved) << "The step has found a root beyond the fold at τ = " << tau << ", margin "
                                 << expected.margin;
            ++unsolvable;
        }
    }
    EXPECT_GT(solvable, 500);
    EXPECT_GT(unsolvable, 20);
}
TYPED_TEST(EulerStep, MatchesTheClosedFormInDouble) { expect_closed_form<TypeParam, double>(40 * TypeParam::step); }
TYPED_TEST(EulerStep, MatchesTheClosedFormInPackets) {
    expect_closed_form<TypeParam, PacketDouble>(40 * TypeParam::step);
}

}  // namespace
}  // namespace kagero::test

// Compares three formulations of the motion of rays, which are derived from the same H by automatic differentiation:
// Hamilton's equations (Satoh 2003, eq. 7), the geodesic equation with Christoffel symbols (eq. 6), and the ray
// equation of a refracting medium (eq. 5). All formulations must give the same acceleration of a ray.
#include "tests/kernels/spaces.h"

#include "kernels/observers/observers.h"

#include <algorithm>

namespace kagero::test {
namespace {

template <class H>
class Formulations : public ::testing::Test {};
TYPED_TEST_SUITE(Formulations, AllHamiltonians, HamiltonianName);

/// Returns H at position q and momentum (p, p_t), in any number type.
template <class H, class T>
T energy_at(const std::array<T, 3>& q, const std::array<T, 4>& p) {
    const auto values = default_parameters<H>();
    std::array<T, H::parameters.size() + 1> k;
    for (std::size_t i = 0; i < k.size(); ++i) k[i] = T(values[i]);
    return H::energy(make_parameters<H>(k.data()), Vec3<T>{q[0], q[1], q[2]}, Vec3<T>{p[0], p[1], p[2]}, p[3]);
}

/// A value with its derivatives with respect to position.
using PositionDual = Dual<double, 3>;

/// Returns d²q/dλ² by Hamilton's equations: ∂²H/∂p∂q · q̇ + ∂²H/∂p∂p · ṗ.
template <class H>
std::array<double, 3> by_hamilton(const RayStart& ray) {
    using PhaseDual = Dual<double, 6>;
    using SecondPhaseDual = Dual<PhaseDual, 6>;
    std::array<SecondPhaseDual, 3> q;
    std::array<SecondPhaseDual, 4> p;
    const auto variable = [](double x, int i) { return SecondPhaseDual::variable(PhaseDual::variable(x, i), i); };
    for (int i = 0; i < 3; ++i) {
        q[i] = variable(ray.q[i], i);
        p[i] = variable(ray.p[i], 3 + i);
    }
    p[3] = SecondPhaseDual(ray.pt);
    const SecondPhaseDual h = energy_at<H>(q, p);
    std::array<double, 3> acceleration{};
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) {
            const auto& row = h.derivative[3 + i].derivative;
            acceleration[i] += row[k] * h.derivative[3 + k].value - row[3 + k] * h.derivative[k].value;
        }
    return acceleration;
}

/// Returns the inverse metric ∂²H/∂p_a∂p_b with its derivatives with respect to position.
template <class H>
std::array<std::array<PositionDual, 4>, 4> inverse_metric(const RayStart& ray) {
    using MomentumDual = Dual<PositionDual, 4>;
    using SecondMomentumDual = Dual<MomentumDual, 4>;
    std::array<SecondMomentumDual, 3> q;
    std::array<SecondMomentumDual, 4> p;
    for (int i = 0; i < 3; ++i) q[i] = SecondMomentumDual(MomentumDual(PositionDual::variable(ray.q[i], i)));
    for (int a = 0; a < 4; ++a) {
        const PositionDual value(a < 3 ? ray.p[a] : ray.pt);
        p[a] = SecondMomentumDual::variable(MomentumDual::variable(value, a), a);
    }
    const SecondMomentumDual h = energy_at<H>(q, p);
    std::array<std::array<PositionDual, 4>, 4> g;
    for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b) g[a][b] = h.derivative[a].derivative[b];
    return g;
}

/// Returns d²x^a/dλ² = −Γ^a_bc ẋ^b ẋ^c for the spatial coordinates. The metric does not depend on time.
template <class H>
std::array<double, 3> by_christoffel(const RayStart& ray) {
    const auto inverse_g = inverse_metric<H>(ray);
    Matrix<4> inverse_g_values;
    for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b) inverse_g_values[a][b] = inverse_g[a][b].value;
    const Matrix<4> g = inverse<4>(inverse_g_values);
    double dg[4][4][4] = {};  // dg[c][a][b] = ∂_c g_ab = −g_am ∂_c g^mn g_nb
    for (int c = 0; c < 3; ++c)
        for (int a = 0; a < 4; ++a)
            for (int b = 0; b < 4; ++b)
                for (int m = 0; m < 4; ++m)
                    for (int n = 0; n < 4; ++n) dg[c][a][b] -= g[a][m] * inverse_g[m][n].derivative[c] * g[n][b];
    double v[4] = {};
    for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b) v[a] += inverse_g_values[a][b] * (b < 3 ? ray.p[b] : ray.pt);
    std::array<double, 3> acceleration{};
    for (int a = 0; a < 3; ++a)
        for (int d = 0; d < 4; ++d)
            for (int b = 0; b < 4; ++b)
                for (int c = 0; c < 4; ++c)
                    acceleration[a] -=
                        0.5 * inverse_g_values[a][d] * (dg[b][d][c] + dg[c][d][b] - dg[d][b][c]) * v[b] * v[c];
    return acceleration;
}

/// Returns d²r/dσ² by the ray equation d/ds (N dr/ds) = ∇N. With dσ = ds/N, this equation becomes d²r/dσ² = ½ ∇N²,
/// where N² = −2 H at p = 0.
template <class H>
std::array<double, 3> by_refraction(const RayStart& ray) {
    std::array<PositionDual, 3> q;
    for (int i = 0; i < 3; ++i) q[i] = PositionDual::variable(ray.q[i], i);
    const PositionDual zero(0);
    const PositionDual h = energy_at<H>(q, std::array<PositionDual, 4>{zero, zero, zero, zero});
    return {-h.derivative[0], -h.derivative[1], -h.derivative[2]};
}

TYPED_TEST(Formulations, GiveTheSameAcceleration) {
    using H = TypeParam;
    for (const RayStart& ray : random_rays<H>(50, 5)) {
        const auto expected = by_hamilton<H>(ray);
        std::array<double, 3> other;
        if constexpr (H::spacetime) other = by_christoffel<H>(ray);
        else if constexpr (H::level == 0) other = by_refraction<H>(ray);
        else GTEST_SKIP() << "H = n p^2/2 describes a medium with another ray parameter.";
        double size = 1;
        for (const double a : expected) size = std::max(size, std::abs(a));
        for (int i = 0; i < 3; ++i) EXPECT_NEAR(other[i], expected[i], 1e5 * machine_epsilon<double> * size) << H::name;
    }
}

}  // namespace
}  // namespace kagero::test

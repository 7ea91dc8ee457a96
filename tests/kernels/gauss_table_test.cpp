// Tests of the coefficients of Gauss–Legendre collocation, which are computed at compile time. They are compared with
// closed forms, and must satisfy the equations that define them.
#include "tests/kernels/spaces.h"

#include "kernels/integrators/gauss.h"

namespace kagero::test {
namespace {

/// About 50 rounding errors in quadruple precision.
constexpr double tolerance = 1e-32;

void expect_near(Quad a, Quad b) { EXPECT_LE(static_cast<double>(abs(a - b)), tolerance); }

Quad power(Quad x, int n) { return n == 0 ? Quad(1) : x * power(x, n - 1); }

TEST(GaussTable, OneStageIsTheMidpointRule) {
    expect_near(gauss_table<1>.c[0], Quad(1) / 2);
    expect_near(gauss_table<1>.b[0], 1);
    expect_near(gauss_table<1>.a[0][0], Quad(1) / 2);
}

// Hairer, Lubich & Wanner (2006), table II.1.1.
TEST(GaussTable, TwoStagesMatchThePublishedTable) {
    const Quad w = sqrt(Quad(3)), c[] = {Quad(1) / 2 - w / 6, Quad(1) / 2 + w / 6};
    const Quad a[2][2] = {{Quad(1) / 4, Quad(1) / 4 - w / 6}, {Quad(1) / 4 + w / 6, Quad(1) / 4}};
    for (int i = 0; i < 2; ++i) {
        expect_near(gauss_table<2>.c[i], c[i]);
        expect_near(gauss_table<2>.b[i], Quad(1) / 2);
        for (int j = 0; j < 2; ++j) expect_near(gauss_table<2>.a[i][j], a[i][j]);
    }
}

// Hairer, Lubich & Wanner (2006), table II.1.1.
TEST(GaussTable, ThreeStagesMatchThePublishedTable) {
    const Quad w = sqrt(Quad(15)), one = 1;
    const Quad c[] = {one / 2 - w / 10, one / 2, one / 2 + w / 10}, b[] = {5 * one / 18, 8 * one / 18, 5 * one / 18};
    const Quad a[3][3] = {{5 * one / 36, 2 * one / 9 - w / 15, 5 * one / 36 - w / 30},
                          {5 * one / 36 + w / 24, 2 * one / 9, 5 * one / 36 - w / 24},
                          {5 * one / 36 + w / 30, 2 * one / 9 + w / 15, 5 * one / 36}};
    for (int i = 0; i < 3; ++i) {
        expect_near(gauss_table<3>.c[i], c[i]);
        expect_near(gauss_table<3>.b[i], b[i]);
        for (int j = 0; j < 3; ++j) expect_near(gauss_table<3>.a[i][j], a[i][j]);
    }
}

/// Checks the equations that define the coefficients of the method with s stages, and its symplecticity and symmetry.
template <int s>
void expect_defining_properties() {
    SCOPED_TRACE(std::to_string(s) + " stages");
    const GaussTable<s>& t = gauss_table<s>;
    for (int n = 0; n < 2 * s; ++n) {  // the weights integrate xⁿ over [0, 1] exactly
        Quad sum = 0;
        for (int i = 0; i < s; ++i) sum += t.b[i] * power(t.c[i], n);
        expect_near(sum, Quad(1) / (n + 1));
    }
    for (int i = 0; i < s; ++i) {
        // Row i of `a` integrates xⁿ over [0, c_i] exactly. Row i of `extrapolation` returns xⁿ at 1 + c_i, which is
        // node i of the next step.
        for (int n = 0; n < s; ++n) {
            Quad integral = 0, value = 0;
            for (int j = 0; j < s; ++j) {
                integral += t.a[i][j] * power(t.c[j], n);
                value += t.extrapolation[i][j] * power(t.c[j], n);
            }
            expect_near(integral, power(t.c[i], n + 1) / (n + 1));
            // The weights in row i of `extrapolation` are large and alternate in sign. The tolerance is therefore
            // relative to the greatest weight.
            Quad size = 0;
            for (int j = 0; j < s; ++j) size = max(size, abs(t.extrapolation[i][j]));
            EXPECT_LE(static_cast<double>(abs(value - power(1 + t.c[i], n)) / size), tolerance);
        }
        // The method is symplectic: b_i a_ij + b_j a_ji = b_i b_j.
        for (int j = 0; j < s; ++j) expect_near(t.b[i] * t.a[i][j] + t.b[j] * t.a[j][i], t.b[i] * t.b[j]);
        // The method is symmetric: a_ij + a_{s+1−i,s+1−j} = b_j for indices from 1 and nodes in ascending order.
        for (int j = 0; j < s; ++j) expect_near(t.a[i][j] + t.a[s - 1 - i][s - 1 - j], t.b[j]);
        EXPECT_TRUE(t.c[i] > (i > 0 ? t.c[i - 1] : Quad(0)) && t.c[i] < 1) << "The nodes must ascend.";
    }
}
TEST(GaussTable, IsExactForPolynomialsSymplecticAndSymmetric) {
    [&]<int... s>(std::integer_sequence<int, s...>) { (expect_defining_properties<s + 1>(), ...); }
    (std::make_integer_sequence<int, max_stages>{});
}

}  // namespace
}  // namespace kagero::test

// Compares two ways to write the Schwarzschild Hamiltonian, eq. (16) of Satoh (2003): the sum of terms as printed, and
// the kernels' formula, in which a perfect square is factored.
#include "tests/kernels/spaces.h"

#include "bench/kernels/printed_schwarzschild.h"

namespace kagero::test {
namespace {

using Printed = bench::PrintedSchwarzschild;

TEST(KerrSchildForm, EqualsThePrintedEquation) {
    Random random(11);
    for (int i = 0; i < 1000; ++i) {
        const double rg = random(0, 2), pt = random(-2, 2);
        const double q[3] = {random(-5, 5), random(-5, 5), random(-5, 5)},
                     p[3] = {random(-2, 2), random(-2, 2), random(-2, 2)};
        const Vec3<double> position{q[0], q[1], q[2]}, momentum{p[0], p[1], p[2]};
        const double h = hamiltonians::Schwarzschild::energy<double>({rg}, position, momentum, pt);
        // `size` bounds the terms of H. The tolerance is 20 rounding errors of this size.
        const double u = std::abs(pt) + norm(momentum), size = 0.5 * (1 + rg / norm(position)) * u * u;
        EXPECT_NEAR(h, Printed::energy<double>({rg}, position, momentum, pt), 20 * machine_epsilon<double> * size);
    }
}

// The tape recognises the perfect square in the printed sum, so that the programs of the printed sum are not longer
// than those of the factored formula.
TEST(KerrSchildForm, PrintedEquationNeedsNoMoreOperations) {
    using Factored = hamiltonians::Schwarzschild;
    EXPECT_LE((derivatives_program<Printed, true>.size), (derivatives_program<Factored, true>.size));
    EXPECT_LE((force_program<Printed, true>.size), (force_program<Factored, true>.size));
    EXPECT_LE((velocity_program<Printed, true>.size), (velocity_program<Factored, true>.size));
    EXPECT_LE((derivatives_program<Printed, false>.size), (derivatives_program<Factored, false>.size));
}

}  // namespace
}  // namespace kagero::test

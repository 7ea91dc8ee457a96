// Eq. (16) as it is printed against the perfect square that the kernels compute.
#include "tests/kernels/spaces.h"

#include "bench/kernels/printed_schwarzschild.h"

namespace kagero::test {
namespace {

using Printed = bench::PrintedSchwarzschild;

TEST(KerrSchildForm, IsThePrintedEquation) {
    Random random(11);
    for (int i = 0; i < 1000; ++i) {
        const double rg = random(0, 2), pt = random(-2, 2);
        const double q[3] = {random(-5, 5), random(-5, 5), random(-5, 5)},
                     p[3] = {random(-2, 2), random(-2, 2), random(-2, 2)};
        const Vec3<double> position{q[0], q[1], q[2]}, momentum{p[0], p[1], p[2]};
        const double h = hamiltonians::Schwarzschild::energy<double>({rg}, position, momentum, pt);
        // Some twenty roundings of terms of this size.
        const double u = std::abs(pt) + norm(momentum), size = 0.5 * (1 + rg / norm(position)) * u * u;
        EXPECT_NEAR(h, Printed::energy<double>({rg}, position, momentum, pt), 20 * machine_epsilon<double> * size);
    }
}

// The tape finds the square again: what is typed in as printed costs no more.
TEST(KerrSchildForm, AsPrintedIsAsShort) {
    using Factored = hamiltonians::Schwarzschild;
    EXPECT_LE((derivatives_program<Printed, true>.size), (derivatives_program<Factored, true>.size));
    EXPECT_LE((force_program<Printed, true>.size), (force_program<Factored, true>.size));
    EXPECT_LE((velocity_program<Printed, true>.size), (velocity_program<Factored, true>.size));
    EXPECT_LE((derivatives_program<Printed, false>.size), (derivatives_program<Factored, false>.size));
}

}  // namespace
}  // namespace kagero::test

// Eq. (16) as it is printed against the perfect square that the kernels compute.
#include "spaces.h"

namespace kagero::test {
namespace {

/// Satoh (2003), eq. (16), term by term: the independent reference.
double printed(double rg, const double (&q)[3], const double (&p)[3], double pt) {
    const auto [x, y, z] = q;
    const auto [px, py, pz] = p;
    const double r = std::sqrt(x * x + y * y + z * z), r2 = r * r, r3 = r2 * r;
    return -0.5 * (1 + rg / r) * pt * pt +
           0.5 * ((1 - rg * x * x / r3) * px * px + (1 - rg * y * y / r3) * py * py + (1 - rg * z * z / r3) * pz * pz) -
           rg * pt / r2 * (x * px + y * py + z * pz) - rg / r3 * (x * y * px * py + x * z * px * pz + y * z * py * pz);
}

TEST(KerrSchildForm, IsThePrintedEquation) {
    Random random(11);
    for (int i = 0; i < 1000; ++i) {
        const double rg = random(0, 2), pt = random(-2, 2);
        const double q[3] = {random(-5, 5), random(-5, 5), random(-5, 5)}, p[3] = {random(-2, 2), random(-2, 2), random(-2, 2)};
        const Vec3<double> position{q[0], q[1], q[2]}, momentum{p[0], p[1], p[2]};
        const double h = hamiltonians::Schwarzschild::energy<double>({rg}, position, momentum, pt);
        // Some twenty roundings of terms of this size.
        const double u = std::abs(pt) + norm(momentum), size = 0.5 * (1 + rg / norm(position)) * u * u;
        EXPECT_NEAR(h, printed(rg, q, p, pt), 20 * machine_epsilon<double> * size);
    }
}

}  // namespace
}  // namespace kagero::test

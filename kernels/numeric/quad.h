/// Quadruple precision as a value type, for measurements of convergence orders beyond the precision of double.
///
/// The relative errors of the functions are some tens of units in the last place. For sin and cos, this holds for the
/// absolute error, in units in the last place of 1, if the argument is moderate. tan is sin/cos. The functions are slow
/// and do not handle overflow.
#pragma once

#include "kernels/simd/circular.h"

namespace kagero {

using Quad = __float128;

template <>
inline constexpr Quad machine_epsilon<Quad> = 1.0 / (static_cast<Quad>(1ull << 56) * (1ull << 56));

inline Quad abs(Quad a) { return a < 0 ? -a : a; }
/// Returns √a, or a itself if a > 0 does not hold.
inline Quad sqrt(Quad a) {
    if (!(a > 0)) return a;
    Quad r = std::sqrt(static_cast<double>(a));
    for (int i = 0; i < 3; ++i) r = (r + a / r) / 2;
    return r;
}
inline Quad rsqrt(Quad a) { return 1 / sqrt(a); }
inline Quad recip(Quad a) { return 1 / a; }
inline Quad total_rsqrt(Quad a) { return rsqrt(a); }
inline Quad total_recip(Quad a) { return recip(a); }
inline Quad fma(Quad a, Quad b, Quad c) { return a * b + c; }
inline Quad fms(Quad a, Quad b, Quad c) { return a * b - c; }
inline Quad fnma(Quad a, Quad b, Quad c) { return c - a * b; }
inline Quad min(Quad a, Quad b) { return a < b ? a : b; }
inline Quad max(Quad a, Quad b) { return a > b ? a : b; }
inline Quad select(bool m, Quad a, Quad b) { return m ? a : b; }

namespace detail {
/// Returns the integer k nearest to a/u, and sets `remainder` to a − k·u. The unit u is the sum u0 + u1 + u2.
inline int reduce(Quad a, double u0, double u1, double u2, Quad& remainder) {
    const Quad unit = static_cast<Quad>(u0) + u1 + u2;
    const int k = static_cast<int>(std::lrint(static_cast<double>(a / unit)));
    remainder = a - k * unit;
    return k;
}
/// Returns sin x (lowest_power = 1) or cos x (lowest_power = 0) for |x| < 1, by the Taylor series.
inline Quad taylor(Quad x, int lowest_power) {
    Quad term = lowest_power ? x : Quad(1), sum = term;
    for (int n = lowest_power + 2; n < 34; n += 2) sum += term *= -x * x / (n * (n - 1));
    return sum;
}
/// Returns sin(a + quarters·π/2).
inline Quad circular(Quad a, int quarters) {
    Quad remainder;
    const int quarter_turns = reduce(a, 1.5707963267948966, 6.123233995736766e-17, -1.4973849048591698e-33, remainder);
    const int quadrant = (quarter_turns + quarters) & 3;
    const Quad value = taylor(remainder, quadrant % 2 == 0);  // the sine in even quadrants, the cosine in odd ones
    return quadrant >= 2 ? -value : value;
}
}  // namespace detail

inline Quad exp(Quad a) {
    Quad remainder;
    const int k = detail::reduce(a, 0.6931471805599453, 2.3190468138462996e-17, 5.707708438416212e-34, remainder);
    Quad term = 1, sum = 1;
    for (int n = 1; n < 34; ++n) sum += term *= remainder / n;
    return sum * std::ldexp(1.0, k);
}
inline Quad log(Quad a) {
    Quad y = std::log(static_cast<double>(a));
    for (int i = 0; i < 2; ++i) {
        const Quad e = exp(y);
        y += 2 * (a - e) / (a + e);
    }
    return y;
}
inline Quad sin(Quad a) { return detail::circular(a, 0); }
inline Quad cos(Quad a) { return detail::circular(a, 1); }
inline Quad tan(Quad a) { return sin(a) / cos(a); }
inline Quad atan2(Quad a, Quad b) {
    Quad angle = std::atan2(static_cast<double>(a), static_cast<double>(b));
    for (int i = 0; i < 2; ++i) {  // adds the remaining angle, computed to first order in it
        const Quad c = cos(angle), s = sin(angle);
        angle += (a * c - b * s) / (b * c + a * s);
    }
    return angle;
}
inline Quad tanh(Quad a) {
    const Quad e = exp(2 * a);
    return (e - 1) / (e + 1);
}

}  // namespace kagero

/// Quadruple precision as a value type, for measuring convergence orders that double cannot show. Arithmetic and √ only.
#pragma once

#include "kernels/numeric/lanes.h"

namespace kagero {

using Quad = __float128;

template <>
inline constexpr Quad machine_epsilon<Quad> = 1.0 / (static_cast<Quad>(1ull << 56) * (1ull << 56));

inline Quad abs(Quad a) { return a < 0 ? -a : a; }
inline Quad sqrt(Quad a) {
    if (!(a > 0)) return a;
    Quad r = std::sqrt(static_cast<double>(a));
    for (int i = 0; i < 3; ++i) r = (r + a / r) / 2;
    return r;
}
inline Quad rsqrt(Quad a) { return 1 / sqrt(a); }
inline Quad recip(Quad a) { return 1 / a; }
inline Quad mul_add(Quad a, Quad b, Quad c) { return a * b + c; }
inline Quad mul_sub(Quad a, Quad b, Quad c) { return a * b - c; }
inline Quad neg_mul_add(Quad a, Quad b, Quad c) { return c - a * b; }
inline Quad min(Quad a, Quad b) { return a < b ? a : b; }
inline Quad max(Quad a, Quad b) { return a > b ? a : b; }
inline Quad pick(bool m, Quad a, Quad b) { return m ? a : b; }

}  // namespace kagero

/// Measurement of the processor's peak rate of multiply-adds, the upper limit of a roofline plot.
#pragma once

#include "kernels/simd/lane_memory.h"

namespace kagero {

/// Runs ten independent chains of `rounds` fused multiply-adds on registers. Eight chains would suffice for two
/// execution units with a latency of four cycles. Returns the number of floating-point operations. Without FMA
/// instructions, each multiply-add is a product followed by a sum.
template <class T>
double multiply_adds(std::uint64_t rounds) {
    using V = Lanes<T, 1>;
    // Every chain converges to 1, so that no number overflows or becomes denormal.
    const V a(T(0.75)), b(T(0.25));
    V x0(T(0.1)), x1(T(0.2)), x2(T(0.3)), x3(T(0.4)), x4(T(0.5)), x5(T(0.6)), x6(T(0.7)), x7(T(0.8)), x8(T(0.9)),
        x9(T(1.1));
    for (std::uint64_t i = 0; i < rounds; ++i) {
        x0 = fma(x0, a, b);
        x1 = fma(x1, a, b);
        x2 = fma(x2, a, b);
        x3 = fma(x3, a, b);
        x4 = fma(x4, a, b);
        x5 = fma(x5, a, b);
        x6 = fma(x6, a, b);
        x7 = fma(x7, a, b);
        x8 = fma(x8, a, b);
        x9 = fma(x9, a, b);
    }
    const V sum = ((x0 + x1) + (x2 + x3)) + ((x4 + x5) + (x6 + x7)) + (x8 + x9);
    [[maybe_unused]] volatile T used = get_lane(sum, 0);  // otherwise the compiler would remove the loop
    return 20.0 * V::width * static_cast<double>(rounds);
}

}  // namespace kagero

/// sin, cos and tan of packets and scalars. The result in a lane is identical to the result for a scalar, and does not
/// depend on the other lanes.
///
/// The argument is reduced to x = n π/2 + r with |r| ≤ π/4; n π/2 is subtracted in three parts (Cody & Waite 1980). The
/// Taylor series of sin r and cos r are evaluated, and the quadrant of x selects one of them and the sign. The absolute
/// error is below 2 ulp of 1. Lanes whose argument is too large for this reduction, or not finite, call the standard
/// library.
#pragma once

#include "kernels/simd/lane_memory.h"

#include <array>

namespace kagero {
namespace detail {

/// Constants of the range reduction and the series. `parts` are three numbers whose sum is π/2, `limit` is the greatest
/// |x| that is reduced, and `degree` is the degree in r² of the Taylor polynomials of (sin r)/r and cos r.
template <class S>
struct QuarterTurn;
template <>
struct QuarterTurn<double> {
    // The first two parts have 33 bits, so that their products with n < 2²⁰ are exact; the third is the remainder.
    static constexpr double parts[3] = {1.57079632673412561417, 6.07710050630396597660e-11, 2.02226624879595063154e-21};
    static constexpr double limit = 1e6;
    static constexpr int degree = 8;
};
template <>
struct QuarterTurn<float> {
    static constexpr float parts[3] = {1.5703125f, 4.837512969970703125e-4f, 7.54978995489188216e-8f};
    static constexpr float limit = 4e3f;
    static constexpr int degree = 5;
};

/// Returns 1/1!, −1/3!, 1/5! etc. for sin (lowest_power = 1), or 1, −1/2!, 1/4! etc. for cos (lowest_power = 0).
template <class S, int lowest_power>
constexpr auto taylor_coefficients() {
    std::array<S, QuarterTurn<S>::degree + 1> c{};
    double factorial = 1;
    for (int n = 0; n < static_cast<int>(c.size()); ++n) {
        c[n] = static_cast<S>((n % 2 ? -1 : 1) / factorial);
        factorial *= (2 * n + lowest_power + 1) * (2 * n + lowest_power + 2);
    }
    return c;
}
/// Returns (sin r)/r (lowest_power = 1) or cos r (lowest_power = 0) by the Taylor series, where `square` is r².
template <int lowest_power, class V>
KAGERO_INLINE V taylor(const V& square) {
    using S = ScalarOf<V>;
    constexpr auto c = taylor_coefficients<S, lowest_power>();
    V sum(c.back());
    for (int n = static_cast<int>(c.size()) - 2; n >= 0; --n) sum = fma(sum, square, V(c[n]));
    return sum;
}

/// Returns `value`, with sin(x + quarters·π/2) of the standard library in the lanes whose bit is set in `lanes`. The
/// function is not inlined, because it is rarely called.
template <int quarters, class V>
[[gnu::noinline, gnu::cold]] V replace_by_library(const V& x, V value, std::uint64_t lanes) {
    for (const int i : lanes_in(lanes))
        set_lane(value, i, quarters ? std::cos(get_lane(x, i)) : std::sin(get_lane(x, i)));
    return value;
}

/// Returns sin(x + quarters·π/2), where `quarters` is 0 (sin x) or 1 (cos x).
template <int quarters, class V>
KAGERO_INLINE V circular(const V& x) {
    using S = ScalarOf<V>;
    using Turn = QuarterTurn<S>;
    // Returns ⌊k/2⌋ for an integer k.
    const auto floor_of_half = [&](const V& k) { return nearest_integer(fms(k, V(S(0.5)), V(S(0.25)))); };
    const V quarter_turns = nearest_integer(x * V(S(0.636619772367581343)));
    V r = fnma(quarter_turns, V(Turn::parts[0]), x);
    r = fnma(quarter_turns, V(Turn::parts[1]), r);
    r = fnma(quarter_turns, V(Turn::parts[2]), r);
    const V square = r * r;
    const V sine = r * taylor<1>(square), cosine = taylor<0>(square);
    // `odd` is quadrant mod 2; 1 selects the cosine. `flipped` is ⌊quadrant/2⌋ mod 2; 1 selects the negative sign.
    const V quadrant = quarter_turns + V(S(quarters)), half = floor_of_half(quadrant);
    const V odd = fnma(V(S(2)), half, quadrant), flipped = fnma(V(S(2)), floor_of_half(half), half);
    const V value = select(odd > V(S(0.5)), cosine, sine) * fnma(V(S(2)), flipped, V(S(1)));
    const auto beyond_limit = !(abs(x) <= V(Turn::limit));  // also true for NaN
    if (!any(beyond_limit)) [[likely]]
        return value;
    return replace_by_library<quarters>(x, value, to_bits(beyond_limit));
}

/// A scalar or packet of double or float.
template <class V>
concept RayNumber = std::is_same_v<ScalarOf<V>, double> || std::is_same_v<ScalarOf<V>, float>;

}  // namespace detail

template <detail::RayNumber V>
KAGERO_INLINE V sin(const V& x) { return detail::circular<0>(x); }
template <detail::RayNumber V>
KAGERO_INLINE V cos(const V& x) { return detail::circular<1>(x); }
template <detail::RayNumber V>
KAGERO_INLINE V tan(const V& x) { return sin(x) / cos(x); }

}  // namespace kagero

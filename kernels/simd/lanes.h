/// The value types of packets and their functions. This is the only header that uses xsimd.
///
/// Kernel code is written once over a value type V. V is `Lanes<T, R>` (R registers of T, one ray per lane), or
/// `double` or `float` for the scalar strategy. Masks are `LaneMask<T, R>` or `bool`. Scalars have the same functions
/// with the same rounding, so that scalar and packet runs agree bit for bit. The exceptions are exp, log, tanh and
/// atan2, which scalars take from the standard library. On AVX-512, recip and rsqrt return NaN for 0 and ∞; total_recip
/// and total_rsqrt return the limits instead.
#pragma once

#include "kernels/simd/bits.h"
#include "kernels/simd/registers.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>

#include <xsimd/xsimd.hpp>

namespace kagero {

/// Executes a statement for each register i < R. The macro contains no loop, because g++ replaces structures by scalars
/// before it unrolls loops, so that structures that are indexed in a loop stay in memory.
#define KAGERO_EACH_REGISTER(...)                                                                                     \
    static_assert(R == 1 || R == 2 || R == 4);                                                                        \
    { constexpr int i = 0; __VA_ARGS__; }                                                                             \
    if constexpr (R > 1) { constexpr int i = 1; __VA_ARGS__; }                                                        \
    if constexpr (R > 2) { { constexpr int i = 2; __VA_ARGS__; } { constexpr int i = 3; __VA_ARGS__; } }

/// A mask for the lanes of Lanes<T, R>: R mask registers.
template <class T, int R>
struct LaneMask {
    using Batch = xsimd::batch_bool<T>;
    typename Batch::register_type v[R];
};

/// A vector of R registers of T. The registers have built-in vector types of the compiler, whose arithmetic needs no
/// function calls; this halves the compilation time.
template <class T, int R>
struct Lanes {
    using Batch = xsimd::batch<T>;
    using Register = typename Batch::register_type;
    static constexpr int width = static_cast<int>(Batch::size);
    Register v[R];

    Lanes() = default;
    KAGERO_INLINE Lanes(T x) {
        KAGERO_EACH_REGISTER(v[i] = Batch(x))
    }
    // Copies register by register, because g++ copies a whole structure through memory.
    KAGERO_INLINE Lanes(const Lanes& other) {
        KAGERO_EACH_REGISTER(v[i] = other.v[i])
    }
    KAGERO_INLINE Lanes& operator=(const Lanes& other) {
        KAGERO_EACH_REGISTER(v[i] = other.v[i])
        return *this;
    }
};

// ---- properties of value types ------------------------------------------------------------------------------------

/// Scalar type, mask type, number of lanes and number of registers of a value type.
template <class V>
struct ValueTraits {
    using Scalar = V;
    using Mask = bool;
    static constexpr int lanes = 1;
    static constexpr int registers = 1;
};
template <class T, int R>
struct ValueTraits<Lanes<T, R>> {
    using Scalar = T;
    using Mask = LaneMask<T, R>;
    static constexpr int lanes = R * Lanes<T, R>::width;
    static constexpr int registers = R;
};
template <class V>
using ScalarOf = typename ValueTraits<V>::Scalar;
template <class V>
using MaskOf = typename ValueTraits<V>::Mask;
template <class V>
inline constexpr int lane_count = ValueTraits<V>::lanes;

/// The distance from 1 to the next greater number.
template <class S>
inline constexpr S machine_epsilon = std::numeric_limits<S>::epsilon();

// ---- packets ------------------------------------------------------------------------------------------------------

namespace detail {

/// Returns atan2(y, x). If x and y are 0, xsimd's function returns NaN, because it divides y by x. This function then
/// returns ±0 or ±π, like std::atan2.
template <class Batch>
KAGERO_INLINE Batch atan2_with_zeros(const Batch& y, const Batch& x) {
    const Batch zero(0), one(1);
    return xsimd::atan2(y, xsimd::select((y == zero) & (x == zero), one | xsimd::bitofsign(x), x));
}

}  // namespace detail

#define KAGERO_LANES_BINARY(NAME, EXPRESSION)                                                  \
    template <class T, int R>                                                            \
    KAGERO_INLINE Lanes<T, R> NAME(const Lanes<T, R>& a, const Lanes<T, R>& b) {         \
        using Batch [[maybe_unused]] = xsimd::batch<T>;                                  \
        Lanes<T, R> c;                                                                   \
        KAGERO_EACH_REGISTER(c.v[i] = EXPRESSION)                                 \
        return c;                                                                        \
    }                                                                                    \
    template <class T, int R>                                                            \
    KAGERO_INLINE Lanes<T, R> NAME(const Lanes<T, R>& a, std::type_identity_t<T> b) {    \
        return NAME(a, Lanes<T, R>(b));                                                  \
    }                                                                                    \
    template <class T, int R>                                                            \
    KAGERO_INLINE Lanes<T, R> NAME(std::type_identity_t<T> a, const Lanes<T, R>& b) {    \
        return NAME(Lanes<T, R>(a), b);                                                  \
    }
KAGERO_LANES_BINARY(operator+, a.v[i] + b.v[i])
KAGERO_LANES_BINARY(operator-, a.v[i] - b.v[i])
KAGERO_LANES_BINARY(operator*, a.v[i] * b.v[i])
KAGERO_LANES_BINARY(operator/, a.v[i] / b.v[i])
KAGERO_LANES_BINARY(min, xsimd::min(Batch(a.v[i]), Batch(b.v[i])))
KAGERO_LANES_BINARY(max, xsimd::max(Batch(a.v[i]), Batch(b.v[i])))
KAGERO_LANES_BINARY(atan2, detail::atan2_with_zeros(Batch(a.v[i]), Batch(b.v[i])))
#undef KAGERO_LANES_BINARY

#define KAGERO_LANES_UNARY(NAME, EXPRESSION)                           \
    template <class T, int R>                                    \
    KAGERO_INLINE Lanes<T, R> NAME(const Lanes<T, R>& a) {       \
        using Batch [[maybe_unused]] = xsimd::batch<T>;          \
        Lanes<T, R> c;                                           \
        KAGERO_EACH_REGISTER(c.v[i] = EXPRESSION)         \
        return c;                                                \
    }
KAGERO_LANES_UNARY(operator-, -a.v[i])
KAGERO_LANES_UNARY(abs, xsimd::abs(Batch(a.v[i])))
KAGERO_LANES_UNARY(sqrt, xsimd::sqrt(Batch(a.v[i])))
KAGERO_LANES_UNARY(exp, xsimd::exp(Batch(a.v[i])))
KAGERO_LANES_UNARY(log, xsimd::log(Batch(a.v[i])))
KAGERO_LANES_UNARY(tanh, xsimd::tanh(Batch(a.v[i])))
#undef KAGERO_LANES_UNARY

template <class T, int R>
KAGERO_INLINE Lanes<T, R>& operator+=(Lanes<T, R>& a, const Lanes<T, R>& b) { return a = a + b; }
template <class T, int R>
KAGERO_INLINE Lanes<T, R>& operator-=(Lanes<T, R>& a, const Lanes<T, R>& b) { return a = a - b; }

#define KAGERO_LANES_TERNARY(NAME, FUNCTION)                                                                          \
    template <class T, int R>                                                                                   \
    KAGERO_INLINE Lanes<T, R> NAME(const Lanes<T, R>& a, const Lanes<T, R>& b, const Lanes<T, R>& c) {          \
        Lanes<T, R> d;                                                                                          \
        KAGERO_EACH_REGISTER(d.v[i] = registers::FUNCTION(a.v[i], b.v[i], c.v[i]))                       \
        return d;                                                                                               \
    }
KAGERO_LANES_TERNARY(fma, fused)          // a·b + c
KAGERO_LANES_TERNARY(fms, fused_sub)      // a·b − c
KAGERO_LANES_TERNARY(fnma, fused_neg)  // c − a·b
#undef KAGERO_LANES_TERNARY

#define KAGERO_LANES_COMPARE(OPERATOR)                                                                    \
    template <class T, int R>                                                                       \
    KAGERO_INLINE LaneMask<T, R> operator OPERATOR(const Lanes<T, R>& a, const Lanes<T, R>& b) {    \
        LaneMask<T, R> m;                                                                           \
        KAGERO_EACH_REGISTER(m.v[i] = xsimd::batch<T>(a.v[i]) OPERATOR xsimd::batch<T>(b.v[i])) \
        return m;                                                                                   \
    }
KAGERO_LANES_COMPARE(<)
KAGERO_LANES_COMPARE(<=)
KAGERO_LANES_COMPARE(>)
KAGERO_LANES_COMPARE(>=)
#undef KAGERO_LANES_COMPARE

#define KAGERO_LANES_LOGIC(OPERATOR)                                                                            \
    template <class T, int R>                                                                             \
    KAGERO_INLINE LaneMask<T, R> operator OPERATOR(const LaneMask<T, R>& a, const LaneMask<T, R>& b) {    \
        using Batch = xsimd::batch_bool<T>;                                                               \
        LaneMask<T, R> m;                                                                                 \
        KAGERO_EACH_REGISTER(m.v[i] = Batch(a.v[i]) OPERATOR Batch(b.v[i]))                                      \
        return m;                                                                                         \
    }
KAGERO_LANES_LOGIC(&)
KAGERO_LANES_LOGIC(|)
#undef KAGERO_LANES_LOGIC
template <class T, int R>
KAGERO_INLINE LaneMask<T, R> operator!(const LaneMask<T, R>& a) {
    LaneMask<T, R> m;
    KAGERO_EACH_REGISTER(m.v[i] = !xsimd::batch_bool<T>(a.v[i]))
    return m;
}

/// Returns a in the lanes where the mask is set, and b in the other lanes.
template <class T, int R>
KAGERO_INLINE Lanes<T, R> select(const LaneMask<T, R>& m, const Lanes<T, R>& a, const Lanes<T, R>& b) {
    Lanes<T, R> c;
    KAGERO_EACH_REGISTER(
        c.v[i] = xsimd::select(xsimd::batch_bool<T>(m.v[i]), xsimd::batch<T>(a.v[i]), xsimd::batch<T>(b.v[i])))
    return c;
}
/// Returns the mask as bits: bit i is set if lane i is set.
template <class T, int R>
KAGERO_INLINE std::uint64_t to_bits(const LaneMask<T, R>& m) {
    std::uint64_t bits = 0;
    KAGERO_EACH_REGISTER(bits |= registers::bits(m.v[i]) << (i * Lanes<T, R>::width))
    return bits;
}
template <class T, int R>
KAGERO_INLINE bool any(const LaneMask<T, R>& m) { return to_bits(m) != 0; }

// ---- scalars, with the rounding of packets ------------------------------------------------------------------------

template <class V>
concept Scalar = std::is_floating_point_v<V>;

#if defined(__FMA__)
template <Scalar V>
KAGERO_INLINE V fma(V a, V b, V c) { return std::fma(a, b, c); }
template <Scalar V>
KAGERO_INLINE V fms(V a, V b, V c) { return std::fma(a, b, -c); }
template <Scalar V>
KAGERO_INLINE V fnma(V a, V b, V c) { return std::fma(-a, b, c); }
#else
template <Scalar V>
KAGERO_INLINE V fma(V a, V b, V c) { return a * b + c; }
template <Scalar V>
KAGERO_INLINE V fms(V a, V b, V c) { return a * b - c; }
template <Scalar V>
KAGERO_INLINE V fnma(V a, V b, V c) { return c - a * b; }
#endif
template <Scalar V>
KAGERO_INLINE V min(V a, V b) { return a < b ? a : b; }
template <Scalar V>
KAGERO_INLINE V max(V a, V b) { return a > b ? a : b; }
template <Scalar V>
KAGERO_INLINE V select(bool m, V a, V b) { return m ? a : b; }
KAGERO_INLINE std::uint64_t to_bits(bool m) { return m; }
KAGERO_INLINE bool any(bool m) { return m; }
using std::abs;
using std::atan2;
using std::exp;
using std::log;
using std::sqrt;
using std::tanh;

// ---- 1/x and 1/√x. AVX-512: a 14-bit estimate and one correction of fourth (double) or second order (float) --------

#if defined(__AVX512F__)
/// Returns 1/√x from the estimate y, with e = 1 − x y²: y + y e (1/2 + e (3/8 + 5/16 e)) in double, and y + y e/2 in
/// float. The error is about 2 ulp. For x = 0 and x = ∞, e is NaN. If `total` is true, min(e, 1) = 1 then replaces e,
/// so that the result is y, which is exact.
template <bool total, class V>
KAGERO_INLINE V refined_rsqrt(const V& x, const V& y) {
    using S = ScalarOf<V>;
    V e = fnma(x * y, y, V(S(1)));
    if constexpr (total) e = min(e, V(S(1)));
    if constexpr (std::is_same_v<S, float>) return fma(y * e, V(S(0.5)), y);
    else return fma(y * e, fma(e, fma(e, V(S(0.3125)), V(S(0.375))), V(S(0.5))), y);
}
/// Returns 1/x from the estimate y, with e = 1 − x y: y + y e (1 + e (1 + e)) in double, and y + y e in float. `total`
/// has the same meaning as for refined_rsqrt.
template <bool total, class V>
KAGERO_INLINE V refined_recip(const V& x, const V& y) {
    using S = ScalarOf<V>;
    V e = fnma(x, y, V(S(1)));
    if constexpr (total) e = min(e, V(S(1)));
    if constexpr (std::is_same_v<S, float>) return fma(y * e, V(S(1)), y);
    else return fma(y * e, fma(e, e + V(S(1)), V(S(1))), y);
}
template <bool total = false, class T, int R>
KAGERO_INLINE Lanes<T, R> rsqrt(const Lanes<T, R>& a) {
    Lanes<T, R> c;
    KAGERO_EACH_REGISTER(c.v[i] = registers::rsqrt14(a.v[i]))
    return refined_rsqrt<total>(a, c);
}
template <bool total = false, class T, int R>
KAGERO_INLINE Lanes<T, R> recip(const Lanes<T, R>& a) {
    Lanes<T, R> c;
    KAGERO_EACH_REGISTER(c.v[i] = registers::recip14(a.v[i]))
    return refined_recip<total>(a, c);
}
template <bool total = false, Scalar V>
KAGERO_INLINE V rsqrt(V a) { return refined_rsqrt<total>(a, registers::rsqrt14(a)); }
template <bool total = false, Scalar V>
KAGERO_INLINE V recip(V a) { return refined_recip<total>(a, registers::recip14(a)); }
#else
template <bool total = false, class T, int R>
KAGERO_INLINE Lanes<T, R> rsqrt(const Lanes<T, R>& a) { return Lanes<T, R>(T(1)) / sqrt(a); }
template <bool total = false, class T, int R>
KAGERO_INLINE Lanes<T, R> recip(const Lanes<T, R>& a) { return Lanes<T, R>(T(1)) / a; }
template <bool total = false, Scalar V>
KAGERO_INLINE V rsqrt(V a) { return V(1) / std::sqrt(a); }
template <bool total = false, Scalar V>
KAGERO_INLINE V recip(V a) { return V(1) / a; }
#endif
/// `total_rsqrt` returns 1/√a, and `total_recip` returns 1/a. Both return the limits for a = 0 and a = ∞ on every
/// instruction set.
template <class V>
KAGERO_INLINE V total_rsqrt(const V& a) { return rsqrt<true>(a); }
template <class V>
KAGERO_INLINE V total_recip(const V& a) { return recip<true>(a); }

// ---- masks and integers -------------------------------------------------------------------------------------------

/// `all_lanes` returns the mask with all lanes set, `no_lanes` the mask with no lane set.
template <class V>
KAGERO_INLINE MaskOf<V> all_lanes() { return V(ScalarOf<V>(0)) <= V(ScalarOf<V>(0)); }
template <class V>
KAGERO_INLINE MaskOf<V> no_lanes() { return V(ScalarOf<V>(0)) > V(ScalarOf<V>(0)); }
/// Returns the integer nearest to a, for |a| < 1/(2ε) with ε = machine_epsilon. Ties are rounded to even.
template <class V>
KAGERO_INLINE V nearest_integer(const V& a) {
    const V rounder(ScalarOf<V>(1.5) / machine_epsilon<ScalarOf<V>>);
    return (a + rounder) - rounder;
}
/// Returns the mask of the lanes that are neither infinite nor NaN.
template <class V>
KAGERO_INLINE MaskOf<V> is_finite(const V& a) { return abs(a) <= V(std::numeric_limits<ScalarOf<V>>::max()); }

}  // namespace kagero

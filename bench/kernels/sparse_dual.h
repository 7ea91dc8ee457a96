/// Dual numbers for forward differentiation. Their type states the variables on which a number depends, so that zero
/// derivatives are neither stored nor multiplied.
#pragma once

#include "kernels/simd/lanes.h"

#include <bit>
#include <utility>

namespace kagero::bench {

using kagero::rsqrt;

inline constexpr int variable_count = 6;

/// Returns true if bit k of `mask` is set: the number depends on variable k.
constexpr bool depends_on(unsigned mask, int k) { return ((mask >> k) & 1) != 0; }
/// Returns the index of the derivative with respect to variable k in SparseDual::derivative.
constexpr int index_of(unsigned mask, int k) { return std::popcount(mask & ((1u << k) - 1)); }

/// A number and its derivatives with respect to the variables in `mask`.
template <class V, unsigned mask>
struct SparseDual {
    V value;
    V derivative[std::popcount(mask) + (mask == 0)];  ///< In the order of the variables; an array must not be empty.
};

/// Returns the number with this value, whose derivative with respect to variable k is rule<k>(), for each k in `mask`.
template <class V, unsigned mask, class Rule>
KAGERO_INLINE SparseDual<V, mask> with_derivatives(const V& value, const Rule& rule) {
    SparseDual<V, mask> d;
    d.value = value;
    const auto one = [&]<int k>() __attribute__((always_inline)) {
        if constexpr (depends_on(mask, k)) d.derivative[index_of(mask, k)] = rule.template operator()<k>();
    };
    [&]<int... k>(std::integer_sequence<int, k...>) __attribute__((always_inline)) {
        (one.template operator()<k>(), ...);
    }(std::make_integer_sequence<int, variable_count>{});
    return d;
}
/// Returns the derivative with respect to variable k.
template <int k, class V, unsigned mask>
KAGERO_INLINE const V& derivative(const SparseDual<V, mask>& x) {
    return x.derivative[index_of(mask, k)];
}
/// Returns variable k with the value x.
template <int k, class V>
KAGERO_INLINE SparseDual<V, 1u << k> variable(const V& x) {
    return {x, {V(ScalarOf<V>(1))}};
}

template <class V, unsigned a, unsigned b>
KAGERO_INLINE SparseDual<V, a | b> operator+(const SparseDual<V, a>& x, const SparseDual<V, b>& y) {
    return with_derivatives<V, a | b>(x.value + y.value, [&]<int k>() __attribute__((always_inline)) {
        if constexpr (depends_on(a, k) && depends_on(b, k)) return derivative<k>(x) + derivative<k>(y);
        else if constexpr (depends_on(a, k)) return derivative<k>(x);
        else return derivative<k>(y);
    });
}
template <class V, unsigned a, unsigned b>
KAGERO_INLINE SparseDual<V, a | b> operator-(const SparseDual<V, a>& x, const SparseDual<V, b>& y) {
    return with_derivatives<V, a | b>(x.value - y.value, [&]<int k>() __attribute__((always_inline)) {
        if constexpr (depends_on(a, k) && depends_on(b, k)) return derivative<k>(x) - derivative<k>(y);
        else if constexpr (depends_on(a, k)) return derivative<k>(x);
        else return -derivative<k>(y);
    });
}
template <class V, unsigned a, unsigned b>
KAGERO_INLINE SparseDual<V, a | b> operator*(const SparseDual<V, a>& x, const SparseDual<V, b>& y) {
    return with_derivatives<V, a | b>(x.value * y.value, [&]<int k>() __attribute__((always_inline)) {
        if constexpr (depends_on(a, k) && depends_on(b, k))
            return fma(derivative<k>(x), y.value, x.value * derivative<k>(y));
        else if constexpr (depends_on(a, k)) return derivative<k>(x) * y.value;
        else return x.value * derivative<k>(y);
    });
}
template <class V, unsigned a>
KAGERO_INLINE SparseDual<V, a> rsqrt(const SparseDual<V, a>& x) {
    const V inverse_root = rsqrt(x.value);
    const V outer = V(ScalarOf<V>(-0.5)) * (inverse_root * inverse_root * inverse_root);  // d(x^-1/2)/dx
    return with_derivatives<V, a>(
        inverse_root, [&]<int k>() __attribute__((always_inline)) { return outer * derivative<k>(x); });
}

}  // namespace kagero::bench

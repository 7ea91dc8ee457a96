/// Forward derivatives whose type says which variables a number depends on: zeros are neither stored nor multiplied.
#pragma once

#include "kernels/simd/lanes.h"

#include <bit>
#include <utility>

namespace kagero::bench {

using kagero::rsqrt;

inline constexpr int variables = 6;

/// Bit k of `on`: the number depends on variable k. Only those derivatives are there.
constexpr bool has(unsigned on, int k) { return ((on >> k) & 1) != 0; }
constexpr int place(unsigned on, int k) { return std::popcount(on & ((1u << k) - 1)); }

template <class V, unsigned on>
struct SparseDual {
    V value;
    V derivative[std::popcount(on) + (on == 0)];
};

/// derivative<k> = rule<k>() for every variable of the result.
template <class V, unsigned on, class Rule>
KAGERO_INLINE SparseDual<V, on> with_derivatives(const V& value, const Rule& rule) {
    SparseDual<V, on> d;
    d.value = value;
    const auto one = [&]<int k>() __attribute__((always_inline)) {
        if constexpr (has(on, k)) d.derivative[place(on, k)] = rule.template operator()<k>();
    };
    [&]<int... k>(std::integer_sequence<int, k...>) __attribute__((always_inline)) {
        (one.template operator()<k>(), ...);
    }(std::make_integer_sequence<int, variables>{});
    return d;
}
template <int k, class V, unsigned on>
KAGERO_INLINE const V& derivative(const SparseDual<V, on>& x) {
    return x.derivative[place(on, k)];
}
template <int k, class V>
KAGERO_INLINE SparseDual<V, 1u << k> variable(const V& x) {
    return {x, {V(ScalarOf<V>(1))}};
}

template <class V, unsigned a, unsigned b>
KAGERO_INLINE SparseDual<V, a | b> operator+(const SparseDual<V, a>& x, const SparseDual<V, b>& y) {
    return with_derivatives<V, a | b>(x.value + y.value, [&]<int k>() __attribute__((always_inline)) {
        if constexpr (has(a, k) && has(b, k)) return derivative<k>(x) + derivative<k>(y);
        else if constexpr (has(a, k)) return derivative<k>(x);
        else return derivative<k>(y);
    });
}
template <class V, unsigned a, unsigned b>
KAGERO_INLINE SparseDual<V, a | b> operator-(const SparseDual<V, a>& x, const SparseDual<V, b>& y) {
    return with_derivatives<V, a | b>(x.value - y.value, [&]<int k>() __attribute__((always_inline)) {
        if constexpr (has(a, k) && has(b, k)) return derivative<k>(x) - derivative<k>(y);
        else if constexpr (has(a, k)) return derivative<k>(x);
        else return -derivative<k>(y);
    });
}
template <class V, unsigned a, unsigned b>
KAGERO_INLINE SparseDual<V, a | b> operator*(const SparseDual<V, a>& x, const SparseDual<V, b>& y) {
    return with_derivatives<V, a | b>(x.value * y.value, [&]<int k>() __attribute__((always_inline)) {
        if constexpr (has(a, k) && has(b, k)) return fma(derivative<k>(x), y.value, x.value * derivative<k>(y));
        else if constexpr (has(a, k)) return derivative<k>(x) * y.value;
        else return x.value * derivative<k>(y);
    });
}
template <class V, unsigned a>
KAGERO_INLINE SparseDual<V, a> rsqrt(const SparseDual<V, a>& x) {
    const V root = rsqrt(x.value), slope = V(ScalarOf<V>(-0.5)) * (root * root * root);
    return with_derivatives<V, a>(
        root, [&]<int k>() __attribute__((always_inline)) { return slope * derivative<k>(x); });
}

}  // namespace kagero::bench

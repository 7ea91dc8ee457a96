/// Forward derivatives whose type says which variables a number depends on: zeros are neither stored nor multiplied.
#pragma once

#include "kernels/numeric/lanes.h"

namespace kagero::bench {

using kagero::rsqrt;

/// Bit k of `on` is variable k; derivatives off these bits are zero and never touched.
template <class V, unsigned on>
struct SparseDual {
    static constexpr int variables = 6;
    static constexpr bool has(int k) { return ((on >> k) & 1) != 0; }
    V value;
    V derivative[variables];
};

template <int k, class V>
KAGERO_INLINE SparseDual<V, 1u << k> variable(const V& x) {
    SparseDual<V, 1u << k> d;
    d.value = x;
    d.derivative[k] = V(ScalarOf<V>(1));
    return d;
}

template <class V, unsigned a, unsigned b>
KAGERO_INLINE SparseDual<V, a | b> operator+(const SparseDual<V, a>& x, const SparseDual<V, b>& y) {
    SparseDual<V, a | b> d;
    d.value = x.value + y.value;
    for (int k = 0; k < x.variables; ++k) {
        if (x.has(k) && y.has(k)) d.derivative[k] = x.derivative[k] + y.derivative[k];
        else if (x.has(k)) d.derivative[k] = x.derivative[k];
        else if (y.has(k)) d.derivative[k] = y.derivative[k];
    }
    return d;
}

template <class V, unsigned a, unsigned b>
KAGERO_INLINE SparseDual<V, a | b> operator-(const SparseDual<V, a>& x, const SparseDual<V, b>& y) {
    SparseDual<V, a | b> d;
    d.value = x.value - y.value;
    for (int k = 0; k < x.variables; ++k) {
        if (x.has(k) && y.has(k)) d.derivative[k] = x.derivative[k] - y.derivative[k];
        else if (x.has(k)) d.derivative[k] = x.derivative[k];
        else if (y.has(k)) d.derivative[k] = -y.derivative[k];
    }
    return d;
}

template <class V, unsigned a, unsigned b>
KAGERO_INLINE SparseDual<V, a | b> operator*(const SparseDual<V, a>& x, const SparseDual<V, b>& y) {
    SparseDual<V, a | b> d;
    d.value = x.value * y.value;
    for (int k = 0; k < x.variables; ++k) {
        if (x.has(k) && y.has(k)) d.derivative[k] = mul_add(x.derivative[k], y.value, x.value * y.derivative[k]);
        else if (x.has(k)) d.derivative[k] = x.derivative[k] * y.value;
        else if (y.has(k)) d.derivative[k] = x.value * y.derivative[k];
    }
    return d;
}

template <class V, unsigned a>
KAGERO_INLINE SparseDual<V, a> rsqrt(const SparseDual<V, a>& x) {
    SparseDual<V, a> d;
    d.value = rsqrt(x.value);
    const V slope = V(ScalarOf<V>(-0.5)) * (d.value * d.value * d.value);
    for (int k = 0; k < x.variables; ++k)
        if (x.has(k)) d.derivative[k] = slope * x.derivative[k];
    return d;
}

}  // namespace kagero::bench

/// Transfers between vectors and memory: access to one lane, loads and stores of all lanes, and table lookup.
#pragma once

#include "kernels/simd/lanes.h"

#include <cstring>

namespace kagero {

/// Returns the number in one lane.
template <class V>
KAGERO_INLINE ScalarOf<V> get_lane(const V& v, int lane) {
    ScalarOf<V> x;
    std::memcpy(&x, reinterpret_cast<const char*>(&v) + static_cast<std::size_t>(lane) * sizeof x, sizeof x);
    return x;
}
/// Sets the number in one lane to x.
template <class V>
KAGERO_INLINE void set_lane(V& v, int lane, ScalarOf<V> x) {
    std::memcpy(reinterpret_cast<char*>(&v) + static_cast<std::size_t>(lane) * sizeof x, &x, sizeof x);
}
/// Returns the vector of the given numbers, one per lane.
template <class V>
KAGERO_INLINE V lanes_of(const double* numbers) {
    if constexpr (lane_count<V> == 1) {
        return static_cast<V>(*numbers);
    } else {
        constexpr int R = ValueTraits<V>::registers;
        V v;
        KAGERO_EACH_REGISTER(registers::from_doubles(v.v[i], numbers + i * V::width))
        return v;
    }
}
/// Stores the lanes in `numbers` as doubles.
template <class V>
KAGERO_INLINE void to_doubles(const V& v, double* numbers) {
    if constexpr (lane_count<V> == 1) {
        *numbers = static_cast<double>(v);
    } else {
        constexpr int R = ValueTraits<V>::registers;
        KAGERO_EACH_REGISTER(registers::to_doubles(v.v[i], numbers + i * V::width))
    }
}
/// Returns the vector of the given numbers, one per lane. Sets `rounding_errors` to the differences between the numbers
/// and the lanes, which are 0 if the lanes are double.
template <class V>
KAGERO_INLINE V lanes_of(const double* numbers, V& rounding_errors) {
    const V v = lanes_of<V>(numbers);
    if constexpr (std::is_same_v<ScalarOf<V>, double>) {
        rounding_errors = V(0.0);
    } else {
        alignas(64) double rounded[lane_count<V>], errors[lane_count<V>];
        to_doubles(v, rounded);
        for (int i = 0; i < lane_count<V>; ++i) errors[i] = numbers[i] - rounded[i];
        rounding_errors = lanes_of<V>(errors);
    }
    return v;
}
/// Stores the lanes in `numbers` as floats.
template <class V>
KAGERO_INLINE void to_floats(const V& v, float* numbers) {
    if constexpr (lane_count<V> == 1) {
        *numbers = static_cast<float>(v);
    } else {
        constexpr int R = ValueTraits<V>::registers;
        KAGERO_EACH_REGISTER(registers::to_floats(v.v[i], numbers + i * V::width))
    }
}
/// Returns table[(z·ny + y)·nx + x] for each lane. x, y and z hold integers ≥ 0 with x < nx and y < ny.
template <class V>
KAGERO_INLINE V look_up(const float* table, const V& x, const V& y, const V& z, int nx, int ny) {
    if constexpr (lane_count<V> == 1) {
        return V(table[(std::size_t(z) * std::size_t(ny) + std::size_t(y)) * std::size_t(nx) + std::size_t(x)]);
    } else {
        constexpr int R = ValueTraits<V>::registers;
        V v;
        KAGERO_EACH_REGISTER(v.v[i] = registers::look_up(table, x.v[i], y.v[i], z.v[i], nx, ny))
        return v;
    }
}
/// Returns the mask whose lane i is set if bit i of `bits` is set.
template <class V>
KAGERO_INLINE MaskOf<V> from_bits(std::uint64_t bits) {
    if constexpr (lane_count<V> == 1) {
        return (bits & 1) != 0;
    } else {
        constexpr int R = ValueTraits<V>::registers;
        MaskOf<V> mask;
        KAGERO_EACH_REGISTER(registers::set_bits(mask.v[i], bits >> (i * V::width)))
        return mask;
    }
}

}  // namespace kagero

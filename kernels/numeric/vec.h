/// Vectors with three components of any number type.
#pragma once

#include "kernels/numeric/quad.h"
#include "kernels/simd/lanes.h"

namespace kagero {

template <class V>
struct Vec3 {
    V x, y, z;
};

template <class V>
constexpr Vec3<V> operator+(const Vec3<V>& a, const Vec3<V>& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
template <class V>
constexpr Vec3<V> operator-(const Vec3<V>& a, const Vec3<V>& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
template <class S, class V>
constexpr Vec3<V> operator*(const S& s, const Vec3<V>& a) { return {V(s) * a.x, V(s) * a.y, V(s) * a.z}; }
template <class V>
constexpr V dot(const Vec3<V>& a, const Vec3<V>& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
template <class V>
constexpr Vec3<V> cross(const Vec3<V>& a, const Vec3<V>& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/// Returns the Euclidean length.
template <class V>
constexpr V norm(const Vec3<V>& a) { return sqrt(dot(a, a)); }
/// Returns the greatest magnitude of a component. Unlike norm, it never overflows.
template <class V>
constexpr V greatest_component(const Vec3<V>& a) {
    return max(max(abs(a.x), abs(a.y)), abs(a.z));
}

}  // namespace kagero

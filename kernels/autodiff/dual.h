/// Forward-mode automatic differentiation: a value with N directional derivatives (the paper's `autodiff`, made generic).
///
/// Nests: `Dual<Dual<double, N>, N>` carries second derivatives. Used where derivatives are needed once per ray or scene, and in tests
/// beside the tape.
#pragma once

#include "kernels/simd/lanes.h"

#include <array>

namespace kagero {

template <class T, int N>
struct Dual {
    T value{};
    std::array<T, N> derivative{};

    constexpr Dual() = default;
    constexpr Dual(double x) : value(x) {}
    constexpr explicit Dual(const T& x) requires(!std::is_same_v<T, double>) : value(x) {}
    /// Variable k of N.
    static constexpr Dual variable(const T& x, int k) {
        Dual d;
        d.value = x;
        d.derivative[k] = T(1.0);
        return d;
    }
    /// f(a) with f and f' known.
    static constexpr Dual chain(const T& f, const T& slope, const Dual& a) {
        Dual d;
        d.value = f;
        for (int k = 0; k < N; ++k) d.derivative[k] = slope * a.derivative[k];
        return d;
    }

    friend constexpr Dual operator-(const Dual& a) {
        Dual d;
        d.value = -a.value;
        for (int k = 0; k < N; ++k) d.derivative[k] = -a.derivative[k];
        return d;
    }
    friend constexpr Dual operator+(const Dual& a, const Dual& b) {
        Dual d;
        d.value = a.value + b.value;
        for (int k = 0; k < N; ++k) d.derivative[k] = a.derivative[k] + b.derivative[k];
        return d;
    }
    friend constexpr Dual operator-(const Dual& a, const Dual& b) {
        Dual d;
        d.value = a.value - b.value;
        for (int k = 0; k < N; ++k) d.derivative[k] = a.derivative[k] - b.derivative[k];
        return d;
    }
    friend constexpr Dual operator*(const Dual& a, const Dual& b) { return combine(a.value * b.value, b.value, a, a.value, b); }
    friend constexpr Dual operator/(const Dual& a, const Dual& b) {
        const T quotient = a.value / b.value;
        return combine(quotient, T(1.0) / b.value, a, -quotient / b.value, b);
    }
    friend constexpr Dual mul_add(const Dual& a, const Dual& b, const Dual& c) { return a * b + c; }
    friend constexpr Dual mul_sub(const Dual& a, const Dual& b, const Dual& c) { return a * b - c; }
    friend constexpr Dual neg_mul_add(const Dual& a, const Dual& b, const Dual& c) { return c - a * b; }
    friend constexpr Dual recip(const Dual& a) { const T r = recip(a.value); return chain(r, -(r * r), a); }
    friend constexpr Dual rsqrt(const Dual& a) { const T r = rsqrt(a.value); return chain(r, T(-0.5) * (r * r * r), a); }
    friend constexpr Dual total_recip(const Dual& a) { const T r = total_recip(a.value); return chain(r, -(r * r), a); }
    friend constexpr Dual total_rsqrt(const Dual& a) { const T r = total_rsqrt(a.value); return chain(r, T(-0.5) * (r * r * r), a); }
    friend constexpr Dual sqrt(const Dual& a) { const T r = sqrt(a.value); return chain(r, T(0.5) / r, a); }
    friend constexpr Dual exp(const Dual& a) { const T e = exp(a.value); return chain(e, e, a); }
    friend constexpr Dual log(const Dual& a) { return chain(log(a.value), T(1.0) / a.value, a); }
    friend constexpr Dual sin(const Dual& a) { return chain(sin(a.value), cos(a.value), a); }
    friend constexpr Dual cos(const Dual& a) { return chain(cos(a.value), -sin(a.value), a); }
    friend constexpr Dual tan(const Dual& a) { const T t = tan(a.value); return chain(t, T(1.0) + t * t, a); }
    friend constexpr Dual tanh(const Dual& a) { const T t = tanh(a.value); return chain(t, T(1.0) - t * t, a); }
    friend constexpr Dual atan2(const Dual& a, const Dual& b) {
        const T size = a.value * a.value + b.value * b.value;
        return combine(atan2(a.value, b.value), b.value / size, a, -a.value / size, b);
    }
    friend constexpr auto operator>=(const Dual& a, const Dual& b) { return primal(a) >= primal(b); }
    template <class Mask>
    friend constexpr Dual pick(const Mask& m, const Dual& a, const Dual& b) {
        Dual d;
        d.value = pick(m, a.value, b.value);
        for (int k = 0; k < N; ++k) d.derivative[k] = pick(m, a.derivative[k], b.derivative[k]);
        return d;
    }
    /// Of equal numbers the first, with its derivative, as on the tape.
    friend constexpr Dual min(const Dual& a, const Dual& b) { return pick(primal(b) >= primal(a), a, b); }
    friend constexpr Dual max(const Dual& a, const Dual& b) { return pick(primal(a) >= primal(b), a, b); }

private:
    static constexpr Dual combine(const T& f, const T& da, const Dual& a, const T& db, const Dual& b) {
        Dual d;
        d.value = f;
        for (int k = 0; k < N; ++k) d.derivative[k] = da * a.derivative[k] + db * b.derivative[k];
        return d;
    }
};

/// The number under all derivatives.
template <class T>
constexpr const T& primal(const T& x) { return x; }
template <class T, int N>
constexpr const auto& primal(const Dual<T, N>& x) { return primal(x.value); }

}  // namespace kagero

/// Forward-mode automatic differentiation: a value with N directional derivatives (the paper's `autodiff`, made
/// generic).
///
/// Nests: `Dual<Dual<double, N>, N>` carries second derivatives. Used where derivatives are needed once per ray or
/// scene, and in tests beside the tape.
#pragma once

#include "kernels/simd/lanes.h"  // first: the functions of plain numbers are declared before the table calls them

#include "kernels/operation.h"

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
    friend constexpr Dual operator*(const Dual& a, const Dual& b) {
        return combine(a.value * b.value, b.value, a, a.value, b);
    }
    friend constexpr Dual operator/(const Dual& a, const Dual& b) {
        const T quotient = a.value / b.value;
        return combine(quotient, T(1.0) / b.value, a, -quotient / b.value, b);
    }
    friend constexpr Dual fma(const Dual& a, const Dual& b, const Dual& c) { return a * b + c; }
    friend constexpr Dual fms(const Dual& a, const Dual& b, const Dual& c) { return a * b - c; }
    friend constexpr Dual fnma(const Dual& a, const Dual& b, const Dual& c) { return c - a * b; }
    friend constexpr Dual total_recip(const Dual& a) { return chained<operations::Recip>(total_recip(a.value), a); }
    friend constexpr Dual total_rsqrt(const Dual& a) { return chained<operations::Rsqrt>(total_rsqrt(a.value), a); }
#define KAGERO_OPERATION(OP, OPERATION)                                                                          \
    friend constexpr Dual OP(const Dual& a)                                                                      \
        requires(operations::OPERATION::operands == 1) { return function_of<operations::OPERATION>(a); }         \
    friend constexpr Dual OP(const Dual& a, const Dual& b)                                                       \
        requires(operations::OPERATION::operands == 2) { return function_of<operations::OPERATION>(a, b); }
    KAGERO_FUNCTIONS(KAGERO_OPERATION)
#undef KAGERO_OPERATION
    friend constexpr auto operator>=(const Dual& a, const Dual& b) { return primal(a) >= primal(b); }
    template <class Mask>
    friend constexpr Dual select(const Mask& m, const Dual& a, const Dual& b) {
        Dual d;
        d.value = select(m, a.value, b.value);
        for (int k = 0; k < N; ++k) d.derivative[k] = select(m, a.derivative[k], b.derivative[k]);
        return d;
    }

private:
    /// A function of the table.
    template <class F>
    static constexpr Dual function_of(const Dual& a) {
        if constexpr (requires { F::recorded(a); }) return F::recorded(a);
        else if constexpr (F::is_abbreviation) return F::value(a);
        else return chained<F>(F::value(a.value), a);
    }
    template <class F>
    static constexpr Dual function_of(const Dual& a, const Dual& b) {
        if constexpr (F::is_abbreviation) return F::value(a, b);
        else if constexpr (requires { F::first(a, b); }) return select(F::first(primal(a), primal(b)), a, b);
        else if constexpr (requires { F::derivative_a(a, b, a); }) {
            const T y = F::value(a.value, b.value);
            return combine(y, F::derivative_a(a.value, b.value, y), a, F::derivative_b(a.value, b.value, y), b);
        } else {
            Dual d;  // constant but for jumps
            d.value = F::value(a.value, b.value);
            return d;
        }
    }
    template <class F>
    static constexpr Dual chained(const T& y, const Dual& a) { return chain(y, F::derivative(a.value, y), a); }
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

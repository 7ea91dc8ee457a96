/// Forward-mode automatic differentiation with dual numbers: a value and its derivatives with respect to N variables
/// (the type `autodiff` of Satoh 2003, but for any number type).
///
/// Dual numbers nest: `Dual<Dual<double, N>, N>` has second derivatives. Dual numbers are used for derivatives that are
/// rarely needed, such as those at ray starts and in rounding bounds, and in tests of the tape.
#pragma once

#include "kernels/simd/lanes.h"  // must come before operation.h, which calls its functions

#include "kernels/operation.h"

#include <array>

namespace kagero {

/// A number of type T with its derivatives with respect to N variables. Its arithmetic is always inlined: the compiler
/// would call functions in the interpreter of formulas, which contains many operations, and a start would take longer.
template <class T, int N>
struct Dual {
    T value{};
    std::array<T, N> derivative{};

    constexpr Dual() = default;
    constexpr Dual(double x) : value(x) {}
    constexpr explicit Dual(const T& x) requires(!std::is_same_v<T, double>) : value(x) {}
    /// Returns the k-th of the N variables, with the value x. Its derivative k is 1; the other derivatives are 0.
    static constexpr Dual variable(const T& x, int k) {
        Dual d;
        d.value = x;
        d.derivative[k] = T(1.0);
        return d;
    }
    /// Returns g(a) for a function g, by the chain rule. `f` is g(a.value), and `slope` is g'(a.value).
    static constexpr Dual chain(const T& f, const T& slope, const Dual& a) {
        Dual d;
        d.value = f;
        for (int k = 0; k < N; ++k) d.derivative[k] = slope * a.derivative[k];
        return d;
    }

    KAGERO_INLINE friend constexpr Dual operator-(const Dual& a) {
        Dual d;
        d.value = -a.value;
        for (int k = 0; k < N; ++k) d.derivative[k] = -a.derivative[k];
        return d;
    }
    KAGERO_INLINE friend constexpr Dual operator+(const Dual& a, const Dual& b) {
        Dual d;
        d.value = a.value + b.value;
        for (int k = 0; k < N; ++k) d.derivative[k] = a.derivative[k] + b.derivative[k];
        return d;
    }
    KAGERO_INLINE friend constexpr Dual operator-(const Dual& a, const Dual& b) {
        Dual d;
        d.value = a.value - b.value;
        for (int k = 0; k < N; ++k) d.derivative[k] = a.derivative[k] - b.derivative[k];
        return d;
    }
    KAGERO_INLINE friend constexpr Dual operator*(const Dual& a, const Dual& b) {
        return combine(a.value * b.value, b.value, a, a.value, b);
    }
    KAGERO_INLINE friend constexpr Dual operator/(const Dual& a, const Dual& b) {
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
    /// Returns F(a) for a function F of operation_table.h.
    template <class F>
    static constexpr Dual function_of(const Dual& a) {
        if constexpr (requires { F::recorded(a); }) return F::recorded(a);
        else if constexpr (F::is_abbreviation) return F::value(a);
        else return chained<F>(F::value(a.value), a);
    }
    /// Returns F(a, b) for a function F of operation_table.h.
    template <class F>
    static constexpr Dual function_of(const Dual& a, const Dual& b) {
        if constexpr (F::is_abbreviation) return F::value(a, b);
        else if constexpr (requires { F::selects_a(a, b); }) return select(F::selects_a(primal(a), primal(b)), a, b);
        else if constexpr (requires { F::is_gate; }) {
            Dual d;
            d.value = F::value(a.value, b.value);
            for (int k = 0; k < N; ++k) d.derivative[k] = F::value(a.value, b.derivative[k]);
            return d;
        } else if constexpr (requires { F::derivative_a(a, b, a); }) {
            const T y = F::value(a.value, b.value);
            return combine(y, F::derivative_a(a.value, b.value, y), a, F::derivative_b(a.value, b.value, y), b);
        } else {
            Dual d;  // F is piecewise constant, so that its derivative is 0
            d.value = F::value(a.value, b.value);
            return d;
        }
    }
    /// Returns F(a) by the chain rule, where y is F(a.value).
    template <class F>
    static constexpr Dual chained(const T& y, const Dual& a) { return chain(y, F::derivative(a.value, y), a); }
    /// Returns g(a, b) for a function g, by the chain rule. `f` is g(a.value, b.value); `da` and `db` are the partial
    /// derivatives of g with respect to a and b.
    KAGERO_INLINE static constexpr Dual combine(const T& f, const T& da, const Dual& a, const T& db, const Dual& b) {
        Dual d;
        d.value = f;
        for (int k = 0; k < N; ++k) d.derivative[k] = da * a.derivative[k] + db * b.derivative[k];
        return d;
    }
};

/// Returns the value of a dual number without its derivatives. If dual numbers are nested, this is the innermost value.
/// Other numbers are returned unchanged.
template <class T>
constexpr const T& primal(const T& x) { return x; }
template <class T, int N>
constexpr const auto& primal(const Dual<T, N>& x) { return primal(x.value); }

}  // namespace kagero

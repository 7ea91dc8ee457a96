/// Coefficients of Gauss–Legendre collocation with s stages and order 2s (Hairer, Lubich & Wanner 2006, §II.1.3). The
/// compiler computes them in quadruple precision.
#pragma once

#include <type_traits>
#include <utility>

namespace kagero {

/// The coefficients for s stages in quadruple precision, for a step from y to y_end of the equation dy/dτ = f(y) with
/// the stages Y_i.
template <int s>
struct GaussTable {
    __float128 a[s][s];  ///< Y_i = y + h Σ_j a_ij f(Y_j)
    __float128 b[s];     ///< y_end = y + h Σ_j b_j f(Y_j)
    __float128 c[s];     ///< positions of the stages, as fractions of the step
    /// Extrapolates f from the stages of a step to the stages of the next step, which has the same length.
    __float128 extrapolation[s][s];
    /// Bézier control point i + 1 of the collocation polynomial: y + h Σ_j control_ij f(Y_j).
    __float128 control[s][s];
};

namespace detail {

/// Value and derivative of a Legendre polynomial.
struct Legendre {
    __float128 value, slope;
};
/// Returns P_n and its derivative at x, by the three-term recurrence.
constexpr Legendre legendre(int n, __float128 x) {
    __float128 previous = 1, current = x;
    for (int k = 2; k <= n; ++k) {
        const __float128 next = ((2 * k - 1) * x * current - (k - 1) * previous) / k;
        previous = current;
        current = next;
    }
    return {current, n * (x * current - previous) / (x * x - 1)};
}
/// Computes the zeros of P_n in ascending order by Newton's method, with deflation of the zeros that are already found.
template <int s>
constexpr void zeros(__float128 (&x)[s]) {
    for (int i = 0; i < s; ++i) {
        __float128 z = i == 0 ? -__float128(0.9999) : x[i - 1] + __float128(0.25) * (1 - x[i - 1]);
        for (int step = 0; step < 200; ++step) {
            const Legendre p = legendre(s, z);
            __float128 deflation = 0;
            for (int k = 0; k < i; ++k) deflation += 1 / (z - x[k]);
            const __float128 change = p.value / (p.slope - p.value * deflation);
            z -= change;
            if (change < 1e-33 && change > -1e-33) break;
        }
        x[i] = z;
    }
    for (int i = 1; i < s; ++i)
        for (int k = i; k > 0 && x[k] < x[k - 1]; --k) std::swap(x[k], x[k - 1]);
}
/// Returns the value at x of Lagrange polynomial j on the nodes c.
template <int s>
constexpr __float128 lagrange(const __float128 (&c)[s], int j, __float128 x) {
    __float128 product = 1;
    for (int k = 0; k < s; ++k)
        if (k != j) product *= (x - c[k]) / (c[j] - c[k]);
    return product;
}

/// Computes the coefficients of Lagrange polynomial j in the Bernstein basis of degree s − 1. Its linear factors
/// x − c_k, with the Bernstein coefficients −c_k and 1 − c_k, are multiplied one after another.
template <int s>
constexpr void bernstein_of_lagrange(const __float128 (&c)[s], int j, __float128 (&coefficient)[s]) {
    coefficient[0] = 1;
    int degree = 0;
    for (int k = 0; k < s; ++k) {
        if (k == j) continue;
        ++degree;
        for (int i = degree; i >= 0; --i) {
            const __float128 from_0 = i < degree ? (degree - i) * coefficient[i] * -c[k] : __float128(0);
            const __float128 from_1 = i > 0 ? i * coefficient[i - 1] * (1 - c[k]) : __float128(0);
            coefficient[i] = (from_0 + from_1) / (degree * (c[j] - c[k]));
        }
    }
}

/// Computes all coefficients for s stages.
template <int s>
constexpr GaussTable<s> make_gauss_table() {
    GaussTable<s> t{};
    __float128 x[s]{};
    if constexpr (s > 1) zeros<s>(x);
    for (int i = 0; i < s; ++i) {
        const __float128 slope = s > 1 ? legendre(s, x[i]).slope : 1;
        t.c[i] = (1 + x[i]) / 2;
        t.b[i] = 1 / ((1 - x[i] * x[i]) * slope * slope);
    }
    for (int i = 0; i < s; ++i) {
        for (int j = 0; j < s; ++j) {
            // The Gauss quadrature with s nodes integrates Lagrange polynomials, of degree s − 1, exactly over [0,
            // c_i].
            __float128 integral = 0;
            for (int k = 0; k < s; ++k) integral += t.b[k] * lagrange<s>(t.c, j, t.c[i] * t.c[k]);
            t.a[i][j] = t.c[i] * integral;
            t.extrapolation[i][j] = lagrange<s>(t.c, j, 1 + t.c[i]);
        }
    }
    for (int j = 0; j < s; ++j) {
        // The derivative of the collocation polynomial with respect to f(Y_j) is h times the integral of Lagrange
        // polynomial j. Integration turns Bernstein coefficients into their partial sums, divided by s.
        __float128 bernstein[s]{}, sum = 0;
        bernstein_of_lagrange<s>(t.c, j, bernstein);
        for (int i = 0; i < s; ++i) t.control[i][j] = sum += bernstein[i] / s;
    }
    return t;
}

}  // namespace detail

template <int s>
inline constexpr GaussTable<s> gauss_table = detail::make_gauss_table<s>();

/// Greatest number of stages of a Gauss–Legendre method.
inline constexpr int max_stages = 8;

/// The coefficients of GaussTable in arrays of a fixed size; entries of unused stages are zero.
template <class S>
struct GaussNumbers {
    S a[max_stages][max_stages], b[max_stages], extrapolation[max_stages][max_stages], control[max_stages][max_stages];
};
/// The coefficients for one number of stages in all precisions. They are rounded at compile time, because a conversion
/// from quadruple precision at run time is a library call.
struct GaussTableau {
    int stages;
    GaussNumbers<__float128> in_quadruple;
    GaussNumbers<double> in_double;
    GaussNumbers<float> in_float;

    /// Returns the coefficients in precision S.
    template <class S>
    constexpr const GaussNumbers<S>& numbers() const {
        if constexpr (std::is_same_v<S, double>) return in_double;
        else if constexpr (std::is_same_v<S, float>) return in_float;
        else return in_quadruple;
    }
};

namespace detail {

/// Returns the coefficients rounded to precision S.
template <class S, int s>
constexpr GaussNumbers<S> rounded_gauss_numbers(const GaussTable<s>& t) {
    GaussNumbers<S> n{};
    for (int i = 0; i < s; ++i) {
        n.b[i] = S(t.b[i]);
        for (int j = 0; j < s; ++j) {
            n.a[i][j] = S(t.a[i][j]);
            n.extrapolation[i][j] = S(t.extrapolation[i][j]);
            n.control[i][j] = S(t.control[i][j]);
        }
    }
    return n;
}

}  // namespace detail

template <int s>
inline constexpr GaussTableau gauss_tableau{s, detail::rounded_gauss_numbers<__float128>(gauss_table<s>),
                                            detail::rounded_gauss_numbers<double>(gauss_table<s>),
                                            detail::rounded_gauss_numbers<float>(gauss_table<s>)};

}  // namespace kagero

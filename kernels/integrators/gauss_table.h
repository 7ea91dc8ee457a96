/// Coefficients of Gauss–Legendre collocation with s stages, order 2s (Hairer, Lubich & Wanner 2006, §II.1.3), computed
/// by the compiler in quadruple precision.
#pragma once

#include <type_traits>
#include <utility>

namespace kagero {

template <int s>
struct GaussTable {
    __float128 a[s][s];       ///< Y_i = y + h Σ a_ij f(Y_j)
    __float128 b[s];          ///< y' = y + h Σ b_j f(Y_j)
    __float128 c[s];
    __float128 ahead[s][s];   ///< extrapolation of the last step's f to the stages of an equal next one
    __float128 control[s][s]; ///< Bézier control point i + 1 of the polynomial: y + h Σ control_ij f(Y_j)
};

namespace detail {

struct Legendre {
    __float128 value, slope;
};
/// P_n and its derivative at x, by the three-term recurrence.
constexpr Legendre legendre(int n, __float128 x) {
    __float128 before = 1, now = x;
    for (int k = 2; k <= n; ++k) {
        const __float128 next = ((2 * k - 1) * x * now - (k - 1) * before) / k;
        before = now;
        now = next;
    }
    return {now, n * (x * now - before) / (x * x - 1)};
}
/// The zeros of P_n, ascending: Newton with the zeros already found divided out.
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
/// Lagrange's polynomial j on the nodes c, at x.
template <int s>
constexpr __float128 lagrange(const __float128 (&c)[s], int j, __float128 x) {
    __float128 product = 1;
    for (int k = 0; k < s; ++k)
        if (k != j) product *= (x - c[k]) / (c[j] - c[k]);
    return product;
}

/// The same polynomial's coefficients in Bernstein's basis of degree s − 1, factor by factor.
template <int s>
constexpr void bernstein_of_lagrange(const __float128 (&c)[s], int j, __float128 (&coefficient)[s]) {
    coefficient[0] = 1;
    int degree = 0;
    for (int k = 0; k < s; ++k) {
        if (k == j) continue;
        ++degree;
        for (int i = degree; i >= 0; --i) {
            const __float128 at_0 = i < degree ? (degree - i) * coefficient[i] * -c[k] : __float128(0);
            const __float128 at_1 = i > 0 ? i * coefficient[i - 1] * (1 - c[k]) : __float128(0);
            coefficient[i] = (at_0 + at_1) / (degree * (c[j] - c[k]));
        }
    }
}

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
            // The integral of a polynomial of degree s − 1 over [0, c_i], exactly, by the same quadrature.
            __float128 integral = 0;
            for (int k = 0; k < s; ++k) integral += t.b[k] * lagrange<s>(t.c, j, t.c[i] * t.c[k]);
            t.a[i][j] = t.c[i] * integral;
            t.ahead[i][j] = lagrange<s>(t.c, j, 1 + t.c[i]);
        }
    }
    for (int j = 0; j < s; ++j) {
        __float128 slope[s]{}, sum = 0;
        bernstein_of_lagrange<s>(t.c, j, slope);
        for (int i = 0; i < s; ++i) t.control[i][j] = sum += slope[i] / s;
    }
    return t;
}

}  // namespace detail

template <int s>
inline constexpr GaussTable<s> gauss_table = detail::make_gauss_table<s>();

inline constexpr int max_stages = 8;

/// The same as run-time data; stages without use are zero.
template <class S>
struct GaussNumbers {
    S a[max_stages][max_stages], b[max_stages], ahead[max_stages][max_stages], control[max_stages][max_stages];
};
/// In every precision, rounded by the compiler: at run time each conversion from quadruple precision is a library call.
struct GaussTableau {
    int stages;
    GaussNumbers<__float128> exact;
    GaussNumbers<double> in_double;
    GaussNumbers<float> in_float;

    template <class S>
    constexpr const GaussNumbers<S>& numbers() const {
        if constexpr (std::is_same_v<S, double>) return in_double;
        else if constexpr (std::is_same_v<S, float>) return in_float;
        else return exact;
    }
};

namespace detail {

template <class S, int s>
constexpr GaussNumbers<S> rounded_gauss_numbers(const GaussTable<s>& t) {
    GaussNumbers<S> n{};
    for (int i = 0; i < s; ++i) {
        n.b[i] = S(t.b[i]);
        for (int j = 0; j < s; ++j)
            n.a[i][j] = S(t.a[i][j]), n.ahead[i][j] = S(t.ahead[i][j]), n.control[i][j] = S(t.control[i][j]);
    }
    return n;
}

}  // namespace detail

template <int s>
inline constexpr GaussTableau gauss_tableau{s, detail::rounded_gauss_numbers<__float128>(gauss_table<s>),
                                            detail::rounded_gauss_numbers<double>(gauss_table<s>),
                                            detail::rounded_gauss_numbers<float>(gauss_table<s>)};

}  // namespace kagero

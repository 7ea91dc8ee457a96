/// The operations that a Hamiltonian may use: one struct each, and one row each of the table at the end of this file.
///
/// The tape, programs, dual numbers, rounding bounds, operation counts, and the interpreter and the parser of formulas
/// all iterate over the table. To add a function, write its struct and append its row to `KAGERO_FUNCTIONS`.
///
/// Members of a struct for an operation y of the operands a and b:
///   name             name of the function in formulas; the symbol of an operator; "" for other operations
///   operands         1 or 2; 3 for fused operations
///   flops            lower bound on the number of floating-point operations; signs and comparisons count as 0
///   rounding         bound on the rounding error of the result, in units of half a unit in the last place
///   is_library       true if the function costs about 40 operations; interpreters then call it instead of inlining it
///   is_composed      true if `value` uses other functions. Otherwise each number type has a function of this name, as
///                    in simd/lanes.h, simd/circular.h and numeric/quad.h.
///   is_abbreviation  true if the tape records other operations instead, so that no derivative is needed
///   value(a, b)      the result y
///   derivative(a, y), or derivative_a(a, b, y) and derivative_b(a, b, y)
///                    the derivatives ∂y/∂a and ∂y/∂b
/// Optional members:
///   recorded(a)      the operations that the tape records for an abbreviation; default: those of `value`
///   total(a, b)      `value` for operands that may be 0, infinite or NaN; used for uniform nodes and formulas
///   selects_a(a, b)  true if the result is operand a, false if it is operand b; replaces the derivatives
///   is_gate          true if the result is operand b or 0, depending on the sign of a; replaces the derivatives
///   adjoint(d, a, y), or adjoint_a(d, a, b, y) and adjoint_b(d, a, b, y)
///                    d·∂y/∂a as recorded on the tape, if the order of its factors matters; default: d·derivative
/// All functions are generic in the number type: scalars, packets, dual numbers and `Recorded` numbers.
/// The arithmetic operations have no derivative here because each number type defines the derivative.
#pragma once

#include "kernels/inline.h"

#ifdef KAGERO_ISA  // the functions of double, float and Quad must be declared before the templates that call them
#include "kernels/numeric/quad.h"
#endif

namespace kagero {
namespace operations {

template <int n>
struct Arithmetic {
    static constexpr const char* name = "";
    static constexpr int operands = n;
    static constexpr double flops = 1, rounding = 1;
    static constexpr bool is_library = false, is_composed = false, is_abbreviation = false;
};
/// A function that every number type defines.
template <int n>
struct Function : Arithmetic<n> {
    /// The fast reciprocals of simd/lanes.h have errors below 2 ulp. The same bound is assumed for other functions.
    static constexpr double rounding = 4;
    static constexpr bool is_library = true;
};
/// A function whose `value` uses other functions. The derived struct must define flops and rounding.
template <int n>
struct ComposedFunction : Arithmetic<n> {
    static constexpr bool is_library = true, is_composed = true;
};
/// The minimum or maximum of two operands. If the operands are equal, the result is the first.
struct Selection : Arithmetic<2> {
    static constexpr double rounding = 0;
};

// ---- arithmetic ----------------------------------------------------------------------------------------------

struct Add : Arithmetic<2> {
    static constexpr const char* name = "+";
    template <class T>
    KAGERO_INLINE static constexpr T value(const T& a, const T& b) { return a + b; }
};
struct Sub : Arithmetic<2> {
    static constexpr const char* name = "-";
    template <class T>
    KAGERO_INLINE static constexpr T value(const T& a, const T& b) { return a - b; }
};
struct Mul : Arithmetic<2> {
    static constexpr const char* name = "*";
    template <class T>
    KAGERO_INLINE static constexpr T value(const T& a, const T& b) { return a * b; }
};
/// Division; the tape records a·(1/b).
struct Div : Arithmetic<2> {
    static constexpr const char* name = "/";
    static constexpr bool is_abbreviation = true;
    template <class T>
    KAGERO_INLINE static constexpr T value(const T& a, const T& b) { return a / b; }
};
struct Neg : Arithmetic<1> {
    static constexpr const char* name = "-";
    static constexpr double flops = 0, rounding = 0;
    template <class T>
    KAGERO_INLINE static constexpr T value(const T& a) { return -a; }
};

/// Fused operations replace a product and a sum when a program is extracted from the tape; tapes contain none.
struct MulAdd : Arithmetic<3> {  // a·b + c
    static constexpr double flops = 2;
    template <class T>
    KAGERO_INLINE static constexpr T value(const T& a, const T& b, const T& c) { return fma(a, b, c); }
};
struct MulSub : Arithmetic<3> {  // a·b − c
    static constexpr double flops = 2;
    template <class T>
    KAGERO_INLINE static constexpr T value(const T& a, const T& b, const T& c) { return fms(a, b, c); }
};
struct NegMulAdd : Arithmetic<3> {  // c − a·b
    static constexpr double flops = 2;
    template <class T>
    KAGERO_INLINE static constexpr T value(const T& a, const T& b, const T& c) { return fnma(a, b, c); }
};

// ---- functions -----------------------------------------------------------------------------------------------

struct Recip : Function<1> {
    static constexpr bool is_library = false;
    template <class T>
    KAGERO_INLINE static constexpr T value(const T& a) { return recip(a); }
    template <class T>
    KAGERO_INLINE static constexpr T total(const T& a) { return total_recip(a); }
    template <class T>
    KAGERO_INLINE static constexpr T derivative(const T&, const T& y) { return -(y * y); }
};
struct Sqrt : Arithmetic<1> {
    static constexpr const char* name = "sqrt";
    template <class T>
    KAGERO_INLINE static constexpr T value(const T& a) { return sqrt(a); }
    template <class T>
    KAGERO_INLINE static constexpr T derivative(const T&, const T& y) { return T(0.5) / y; }
};
struct Rsqrt : Function<1> {
    static constexpr bool is_library = false;
    template <class T>
    KAGERO_INLINE static constexpr T value(const T& a) { return rsqrt(a); }
    template <class T>
    KAGERO_INLINE static constexpr T total(const T& a) { return total_rsqrt(a); }
    template <class T>
    KAGERO_INLINE static constexpr T derivative(const T&, const T& y) { return T(-0.5) * (y * y * y); }
    /// Computes y·y as a separate factor, which derivatives of other powers of y can share.
    template <class T>
    static constexpr T adjoint(const T& d, const T&, const T& y) { return T(-0.5) * ((d * y) * (y * y)); }
};
struct Exp : Function<1> {
    static constexpr const char* name = "exp";
    template <class T>
    KAGERO_INLINE static constexpr T value(const T& a) { return exp(a); }
    template <class T>
    KAGERO_INLINE static constexpr T derivative(const T&, const T& y) { return y; }
};
struct Log : Function<1> {
    static constexpr const char* name = "log";
    template <class T>
    KAGERO_INLINE static constexpr T value(const T& a) { return log(a); }
    template <class T>
    KAGERO_INLINE static constexpr T derivative(const T& a, const T&) { return T(1.0) / a; }
};
struct Sin : Function<1> {
    static constexpr const char* name = "sin";
    template <class T>
    KAGERO_INLINE static constexpr T value(const T& a) { return sin(a); }
    template <class T>
    KAGERO_INLINE static constexpr T derivative(const T& a, const T&) { return cos(a); }
};
struct Cos : Function<1> {
    static constexpr const char* name = "cos";
    template <class T>
    KAGERO_INLINE static constexpr T value(const T& a) { return cos(a); }
    template <class T>
    KAGERO_INLINE static constexpr T derivative(const T& a, const T&) { return -sin(a); }
};
struct Tan : Function<1> {
    static constexpr const char* name = "tan";
    template <class T>
    KAGERO_INLINE static constexpr T value(const T& a) { return tan(a); }
    template <class T>
    KAGERO_INLINE static constexpr T derivative(const T&, const T& y) { return T(1.0) + y * y; }
};
struct Tanh : Function<1> {
    static constexpr const char* name = "tanh";
    template <class T>
    KAGERO_INLINE static constexpr T value(const T& a) { return tanh(a); }
    template <class T>
    KAGERO_INLINE static constexpr T derivative(const T&, const T& y) { return T(1.0) - y * y; }
};
struct Atan2 : Function<2> {
    static constexpr const char* name = "atan2";
    template <class T>
    KAGERO_INLINE static constexpr T value(const T& a, const T& b) { return atan2(a, b); }
    template <class T>
    KAGERO_INLINE static constexpr T derivative_a(const T& a, const T& b, const T&) { return b / (a * a + b * b); }
    template <class T>
    KAGERO_INLINE static constexpr T derivative_b(const T& a, const T& b, const T&) { return -a / (a * a + b * b); }
    /// The two derivatives share d/(a² + b²).
    template <class T>
    static constexpr T adjoint_a(const T& d, const T& a, const T& b, const T&) {
        return d * (T(1.0) / (a * a + b * b)) * b;
    }
    template <class T>
    static constexpr T adjoint_b(const T& d, const T& a, const T& b, const T&) {
        return -(d * (T(1.0) / (a * a + b * b)) * a);
    }
};
struct Min : Selection {
    static constexpr const char* name = "min";
    template <class T>
    KAGERO_INLINE static constexpr T value(const T& a, const T& b) { return min(a, b); }
    /// Returns NaN if the first operand is NaN. Dual numbers do not support this comparison; for them this is `value`.
    template <class T>
    KAGERO_INLINE static constexpr T total(const T& a, const T& b) {
        if constexpr (requires { a <= a; }) return select(a <= a, min(a, b), a);
        else return min(a, b);
    }
    template <class T>
    KAGERO_INLINE static constexpr auto selects_a(const T& a, const T& b) { return b >= a; }
};
struct Max : Selection {
    static constexpr const char* name = "max";
    template <class T>
    KAGERO_INLINE static constexpr T value(const T& a, const T& b) { return max(a, b); }
    template <class T>
    KAGERO_INLINE static constexpr T total(const T& a, const T& b) {
        if constexpr (requires { a <= a; }) return select(a <= a, max(a, b), a);
        else return max(a, b);
    }
    template <class T>
    KAGERO_INLINE static constexpr auto selects_a(const T& a, const T& b) { return a >= b; }
};
/// A gate: the second operand where the condition c is greater than 0 (IfPositive), or where it is not
/// (UnlessPositive); else 0, even if the operand is infinite or NaN. The sum of two gates with the same c is a branch:
/// where(c, a, b) in formulas. Both are 0 or an operand if c is NaN; `total` is then NaN.
template <bool passes_positive>
struct Gate : ComposedFunction<2> {
    static constexpr double flops = 0, rounding = 0;
    static constexpr bool is_library = false, is_gate = true;
    template <class T>
    KAGERO_INLINE static constexpr T value(const T& c, const T& a) {
        if constexpr (passes_positive) return select(T(0.0) >= c, T(0.0), a);
        else return select(T(0.0) >= c, a, T(0.0));
    }
    template <class T>
    KAGERO_INLINE static constexpr T total(const T& c, const T& a) {
        if constexpr (requires { c <= c; }) return select(c <= c, value(c, a), c);
        else return value(c, a);
    }
};
struct IfPositive : Gate<true> {};
struct UnlessPositive : Gate<false> {};
/// The step function: 1 if a ≥ b, else 0. Its derivative is taken as 0.
struct AtLeast : ComposedFunction<2> {
    static constexpr double flops = 0, rounding = 0;
    static constexpr bool is_library = false;
    template <class T>
    KAGERO_INLINE static constexpr T value(const T& a, const T& b) { return select(a >= b, T(1.0), T(0.0)); }
};
struct Abs : Arithmetic<1> {
    static constexpr const char* name = "abs";
    static constexpr bool is_abbreviation = true;
    template <class T>
    KAGERO_INLINE static constexpr T value(const T& a) { return abs(a); }
    template <class T>
    static constexpr T recorded(const T& a) { return max(a, -a); }
};
struct Atan : ComposedFunction<1> {
    static constexpr const char* name = "atan";
    static constexpr double rounding = 4;
    template <class T>
    KAGERO_INLINE static constexpr T value(const T& a) { return atan2(a, T(1.0)); }
    template <class T>
    KAGERO_INLINE static constexpr T derivative(const T& a, const T&) { return T(1.0) / (T(1.0) + a * a); }
};
/// The arc sine. The product (1 − a)(1 + a) is accurate where 1 − a² would cancel.
struct Asin : ComposedFunction<1> {
    static constexpr const char* name = "asin";
    static constexpr double rounding = 8;
    template <class T>
    KAGERO_INLINE static constexpr T value(const T& a) { return atan2(a, sqrt((T(1.0) - a) * (T(1.0) + a))); }
    template <class T>
    KAGERO_INLINE static constexpr T derivative(const T& a, const T&) {
        return rsqrt((T(1.0) - a) * (T(1.0) + a));
    }
};
struct Acos : ComposedFunction<1> {
    static constexpr const char* name = "acos";
    static constexpr double rounding = 8;
    template <class T>
    KAGERO_INLINE static constexpr T value(const T& a) { return atan2(sqrt((T(1.0) - a) * (T(1.0) + a)), a); }
    template <class T>
    KAGERO_INLINE static constexpr T derivative(const T& a, const T&) {
        return -rsqrt((T(1.0) - a) * (T(1.0) + a));
    }
};
struct Cosh : ComposedFunction<1> {
    static constexpr const char* name = "cosh";
    static constexpr double rounding = 6;
    template <class T>
    KAGERO_INLINE static constexpr T value(const T& a) { return T(0.5) * (exp(a) + exp(-a)); }
    template <class T>
    KAGERO_INLINE static constexpr T derivative(const T& a, const T& y) { return tanh(a) * y; }
};
/// The hyperbolic sine as tanh · cosh, which does not cancel near 0.
struct Sinh : ComposedFunction<1> {
    static constexpr const char* name = "sinh";
    static constexpr double rounding = 12;
    template <class T>
    KAGERO_INLINE static constexpr T value(const T& a) { return tanh(a) * Cosh::value(a); }
    template <class T>
    KAGERO_INLINE static constexpr T derivative(const T& a, const T&) { return Cosh::value(a); }
};

}  // namespace operations

/// The table: X(name in `Op`, struct). The scheduler of formula programs prefers the earlier row if two operations are
/// equally frequent among those that are ready; new rows therefore go to the end of a list.
#define KAGERO_ARITHMETIC(X) X(add, Add) X(sub, Sub) X(mul, Mul) X(div, Div) X(neg, Neg)
#define KAGERO_FUNCTIONS(X)            \
    X(recip, Recip)                    \
    X(sqrt, Sqrt)                      \
    X(rsqrt, Rsqrt)                    \
    X(exp, Exp)                        \
    X(log, Log)                        \
    X(sin, Sin)                        \
    X(cos, Cos)                        \
    X(tan, Tan)                        \
    X(tanh, Tanh)                      \
    X(atan2, Atan2)                    \
    X(min, Min)                        \
    X(max, Max)                        \
    X(at_least, AtLeast)               \
    X(abs, Abs)                        \
    X(atan, Atan)                      \
    X(asin, Asin)                      \
    X(acos, Acos)                      \
    X(sinh, Sinh)                      \
    X(cosh, Cosh)                      \
    X(if_positive, IfPositive)         \
    X(unless_positive, UnlessPositive)
#define KAGERO_FUSED(X) X(fma, MulAdd) X(fms, MulSub) X(fnma, NegMulAdd)
#define KAGERO_OPERATIONS(X) KAGERO_ARITHMETIC(X) KAGERO_FUNCTIONS(X) KAGERO_FUSED(X)

}  // namespace kagero

/// The number type `Recorded`, which records operations on a tape.
#pragma once

#include "kernels/autodiff/tape.h"

namespace kagero {

/// A number that records each operation on a tape. It is a node of a tape, or a constant that is on no tape yet.
struct Recorded {
    Tape* tape = nullptr;
    int node = -1;
    double value = 0;  ///< Value of a constant that is on no tape.

    constexpr Recorded() = default;
    constexpr Recorded(double x) : value(x) {}
    constexpr Recorded(Tape* t, int n) : tape(t), node(n) {}
    /// Returns the node of this number. A constant that is on no tape is recorded on t first.
    constexpr int node_on(Tape& t) const { return tape ? node : t.constant(value); }
};

#define KAGERO_RECORD_BINARY(OPERATOR, FUNCTION)                                   \
    constexpr Recorded operator OPERATOR(const Recorded& a, const Recorded& b) {  \
        Tape* t = a.tape ? a.tape : b.tape;                                       \
        if (!t) return a.value OPERATOR b.value;                                  \
        const int i = a.node_on(*t), j = b.node_on(*t);                           \
        return {t, t->FUNCTION(i, j)};                                            \
    }
KAGERO_RECORD_BINARY(+, add)
KAGERO_RECORD_BINARY(-, sub)
KAGERO_RECORD_BINARY(*, mul)
KAGERO_RECORD_BINARY(/, div)
#undef KAGERO_RECORD_BINARY
constexpr Recorded operator-(const Recorded& a) {
    if (!a.tape) return -a.value;
    return {a.tape, a.tape->neg(a.node)};
}
/// Records the operation `at_least`, whose value is 1 if a ≥ b, else 0.
constexpr Recorded operator>=(const Recorded& a, const Recorded& b);

namespace detail {

/// Records a function of operation_table.h, or computes its value if no operand is on a tape.
template <Op op, class... A>
constexpr Recorded recorded_function(const A&... a) {
    using F = Operation<op>;
    if constexpr (F::is_abbreviation) {
        if constexpr (requires { F::recorded(a...); }) return F::recorded(a...);
        else return F::value(a...);
    } else {
        Tape* t = nullptr;
        ((t = t ? t : a.tape), ...);
        if (!t) return F::value(a.value...);
        const int node[] = {a.node_on(*t)...};
        return {t, t->function(op, node[0], sizeof...(A) > 1 ? node[sizeof...(A) - 1] : -1)};
    }
}
/// True if the types A are operands of `op`: their number is right, and at least one is `Recorded`.
template <Op op, class... A>
concept RecordedOperands = sizeof...(A) == Operation<op>::operands && (std::is_same_v<A, Recorded> || ...) &&
                           (std::is_convertible_v<A, Recorded> && ...);

}  // namespace detail

#define KAGERO_OPERATION(OP, OPERATION)                         \
    template <class... A>                                       \
        requires detail::RecordedOperands<Op::OP, A...>         \
    constexpr Recorded OP(const A&... a) { return detail::recorded_function<Op::OP>(Recorded(a)...); }
KAGERO_FUNCTIONS(KAGERO_OPERATION)
#undef KAGERO_OPERATION

constexpr Recorded operator>=(const Recorded& a, const Recorded& b) { return at_least(a, b); }

/// Records an operation of a formula and returns its node; −1 for leaves and fused operations. a and b are nodes; b is
/// ignored if the operation has one operand.
constexpr int record(Tape& t, Op op, int a, int b) {
    const Recorded x(&t, a), y(&t, b);
    const auto arithmetic = [&]<Op static_op>() -> Recorded {
        if constexpr (Operation<static_op>::operands == 1) return Operation<static_op>::value(x);
        else return Operation<static_op>::value(x, y);
    };
    const auto function = [&]<Op static_op>() -> Recorded {
        if constexpr (Operation<static_op>::operands == 1) return detail::recorded_function<static_op>(x);
        else return detail::recorded_function<static_op>(x, y);
    };
    switch (op) {
#define KAGERO_OPERATION(OP, OPERATION) case Op::OP: return arithmetic.template operator()<Op::OP>().node;
        KAGERO_ARITHMETIC(KAGERO_OPERATION)
#undef KAGERO_OPERATION
#define KAGERO_OPERATION(OP, OPERATION) case Op::OP: return function.template operator()<Op::OP>().node;
        KAGERO_FUNCTIONS(KAGERO_OPERATION)
#undef KAGERO_OPERATION
        default: return -1;
    }
}

}  // namespace kagero

/// The number type `Recorded`, which records operations on a tape.
#pragma once

#include "kernels/autodiff/tape.h"

namespace kagero {

/// A number that records each operation on a tape: a node of a tape, or a constant that is not yet on one.
struct Recorded {
    Tape* tape = nullptr;
    int node = -1;
    double value = 0;  ///< Value of a constant without a tape.

    constexpr Recorded() = default;
    constexpr Recorded(double x) : value(x) {}
    constexpr Recorded(Tape* t, int n) : tape(t), node(n) {}
    /// Returns the node. A constant that has no tape is recorded on t first.
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
/// Records 1 if a ≥ b, else 0.
constexpr Recorded operator>=(const Recorded& a, const Recorded& b);

namespace detail {

/// Records a function of operation_table.h, or computes its value if no operand has a tape.
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

/// Records an operation of a formula and returns its node. a and b are nodes; b is ignored if the operation has one
/// operand.
constexpr int record(Tape& t, Op op, int a, int b) {
    const Recorded x(&t, a), y(&t, b);
    const auto arithmetic = [&]<Op of>() -> Recorded {
        if constexpr (Operation<of>::operands == 1) return Operation<of>::value(x);
        else return Operation<of>::value(x, y);
    };
    const auto function = [&]<Op of>() -> Recorded {
        if constexpr (Operation<of>::operands == 1) return detail::recorded_function<of>(x);
        else return detail::recorded_function<of>(x, y);
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

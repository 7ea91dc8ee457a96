/// Evaluation of straight-line programs. `run` is unrolled over the nodes of a program by an index sequence. All
/// operands are compile-time indices, so that the compiler generates the same code as for a C++ expression.
#pragma once

#include "kernels/autodiff/arrange.h"
#include "kernels/autodiff/gradient.h"

#include <utility>

namespace kagero {

namespace detail {

/// Returns the result of the operation F, a struct of operation_table.h. F uses the first F::operands of a, b and c.
template <class F, class V>
KAGERO_INLINE V value_at([[maybe_unused]] const V& a, [[maybe_unused]] const V& b, [[maybe_unused]] const V& c) {
    if constexpr (F::operands == 1) return F::value(a);
    else if constexpr (F::operands == 2) return F::value(a, b);
    else return F::value(a, b, c);
}
/// The same as `value_at` for functions of one or two operands, but never inlined.
template <class F, class V>
__attribute__((noinline)) V value_by_call(const V& a, const V& b) { return value_at<F>(a, b, b); }

/// Returns op(a, b, c). If `call` is true, an operation with the flag `is_library` (operation_table.h) is not inlined.
template <Op op, bool call, class V>
KAGERO_INLINE V apply(const V& a, const V& b, const V& c) {
    using F = Operation<op>;
    if constexpr (F::is_library && call) return value_by_call<F>(a, b);
    else return value_at<F>(a, b, c);
}

/// Returns op(a, b, c) for operands that may be 0, infinite or NaN. Such operands occur in uniform nodes, and in
/// formulas whose exponentials overflow.
template <Op op, bool call, class V>
KAGERO_INLINE V apply_total(const V& a, const V& b, const V& c) {
    using F = Operation<op>;
    if constexpr (requires { F::total(a); }) return F::total(a);
    else if constexpr (requires { F::total(a, b); }) return F::total(a, b);
    else return apply<op, call, V>(a, b, c);
}

/// Returns op(a, b, c) for an operation that is not a compile-time constant. Abbreviations (see operation_table.h) are
/// not supported, because programs contain none.
template <class V>
V apply_at_run_time(Op op, const V& a, const V& b, const V& c) {
    const auto result = [&]<Op static_op>() __attribute__((always_inline)) -> V {
        if constexpr (Operation<static_op>::is_abbreviation) return a;
        else return apply_total<static_op, false, V>(a, b, c);
    };
    switch (op) {
#define KAGERO_OPERATION(OP, OPERATION) \
    case Op::OP: return result.template operator()<Op::OP>();
        KAGERO_OPERATIONS(KAGERO_OPERATION)
#undef KAGERO_OPERATION
        default: return a;
    }
}

/// Returns true if program P calls a function for the operation instead of inlining it.
template <const auto& P>
constexpr bool calls(Op op) {
    constexpr bool calls_sin_cos = P.calls_sin_cos();
    return calls_sin_cos && (op == Op::sin || op == Op::cos);
}

/// Evaluates node i of a program and stores its value in s[i]. s contains the values of the earlier nodes. `call` has
/// the same meaning as in `apply`. The index, operands and slot of the node are function arguments, which become
/// constants after inlining. If they were template arguments, long programs would take a third longer to compile.
template <Op op, bool uniform, bool call, class V, class S>
KAGERO_INLINE void evaluate(V* s, int i, const Node& n, int slot, const S* uniforms, const V* inputs) {
    if constexpr (op == Op::input) s[i] = inputs[n.a];
    else if constexpr (op == Op::constant) s[i] = V(S(n.value));
    else if constexpr (uniform) s[i] = V(uniforms[slot]);
    else s[i] = apply<op, call, V>(s[n.a], s[n.b < 0 ? n.a : n.b], s[n.c < 0 ? n.a : n.c]);
}

/// Implements `run`. I are the indices of all nodes, and O those of all outputs.
template <const auto& P, class V, class S, int... I, int... O>
KAGERO_INLINE void run(const S* uniforms, const V* inputs, V* outputs, std::integer_sequence<int, I...>,
                       std::integer_sequence<int, O...>) {
    V s[sizeof...(I) + 1];
    ((evaluate<P.nodes[I].op, P.nodes[I].uniform, calls<P>(P.nodes[I].op), V>(s, I, P.nodes[I], P.slot[I], uniforms,
                                                                              inputs)),
     ...);
    ((outputs[O] = s[P.outputs[O]]), ...);
}

}  // namespace detail

/// Evaluates program P: computes `outputs` from `inputs` and from the uniforms that `fill_uniforms` has written.
template <const auto& P, class V, class S>
KAGERO_INLINE void run(const S* uniforms, const V* inputs, V* outputs) {
    detail::run<P>(uniforms, inputs, outputs, std::make_integer_sequence<int, P.size>{},
                   std::make_integer_sequence<int, static_cast<int>(P.outputs.size())>{});
}

inline double value_of(Op op, double a, double b) { return detail::apply_at_run_time(op, a, b, b); }

/// Evaluates the uniform nodes of a program. Writes the value of each node i with slot[i] ≥ 0 to uniforms[slot[i]].
template <class S>
void fill_uniforms(const Node* nodes, const int* slot, int size, const S* parameters, S* uniforms) {
    S value[Tape::capacity];
    for (int i = 0; i < size; ++i) {
        const Node& n = nodes[i];
        if (!n.uniform) continue;
        const S a = n.a >= 0 && n.op != Op::parameter ? value[n.a] : S(0), b = n.b >= 0 ? value[n.b] : S(0);
        switch (n.op) {
            case Op::constant: value[i] = S(n.value); break;
            case Op::parameter: value[i] = parameters[n.a]; break;
            default: value[i] = detail::apply_at_run_time(n.op, a, b, b); break;
        }
        if (slot[i] >= 0) uniforms[slot[i]] = value[i];
    }
}

// Instantiated in module.cpp.
extern template void fill_uniforms<double>(const Node*, const int*, int, const double*, double*);

}  // namespace kagero

/// Rounding errors of straight-line programs by a reverse sweep (Iri 1988): what an operation is off by reaches the
/// result times the adjoint of that operation.
#pragma once

#include "kernels/autodiff/dual.h"
#include "kernels/autodiff/listing.h"

namespace kagero {

/// The greatest power of two that is not above |x|: a last place of x, in those of 1 (Rump, Ogita & Oishi, SIAM J. Sci.
/// Comput. 31, 2008).
template <class V>
KAGERO_INLINE V first_place(const V& x) {
    const V scaled = V(0x1p52 + 1) * x;
    return abs(scaled - V(1 - 0x1p-53) * scaled);
}

namespace detail {

/// The product that a sum of products rounds on its own, where the instruction set has no fused operation for them;
/// else none.
template <class V>
KAGERO_INLINE V product_rounded_apart([[maybe_unused]] Op op, [[maybe_unused]] const V& a,
                                      [[maybe_unused]] const V& b) {
#if !defined(__FMA__)
    if (info_of(op).operands == 3) return a * b;
#endif
    return V(0.0);
}

}  // namespace detail

/// Σ |adjoint · last place of the value| over the operations of a program that reads `inputs`. `seeds` are its outputs'
/// adjoints with regard to two numbers (2 × outputs), which count by their length. In units of half the last place of
/// 1.
template <class V, class S>
V sum_of_roundings(const Listed<S>& listed, const V* inputs, const V* seeds, int outputs) {
    using Forward = Dual<V, most_operands>;
    const Listing& program = listed.program;
    V value[Tape::capacity], adjoint[Tape::capacity][2];
    const V zero(S(0));
    const auto of = [&](int k) -> const V& { return k < 0 ? zero : value[k]; };
    evaluate(listed, inputs, value);
    for (int i = 0; i < program.size; ++i) adjoint[i][0] = adjoint[i][1] = zero;
    for (int o = 0; o < outputs; ++o)
        for (int r = 0; r < 2; ++r) adjoint[program.outputs[o]][r] += seeds[r * outputs + o];
    V sum = zero;
    for (int i = program.size - 1; i >= 0; --i) {
        const Node& n = program.nodes[i];
        if (detail::is_leaf(n.op)) continue;
        const int operands[most_operands] = {n.a, n.b, n.c};
        const Forward result = detail::applied<Forward>(n.op, Forward::variable(of(n.a), 0),
                                                        Forward::variable(of(n.b), 1), Forward::variable(of(n.c), 2));
        for (int k = 0; k < most_operands; ++k)
            for (int r = 0; r < 2 && operands[k] >= 0; ++r)
                adjoint[operands[k]][r] = fma(adjoint[i][r], result.derivative[k], adjoint[operands[k]][r]);
        const V reach = sqrt(adjoint[i][0] * adjoint[i][0] + adjoint[i][1] * adjoint[i][1]);
        sum += V(S(info_of(n.op).rounding)) * reach * first_place(value[i]);
        sum += reach * first_place(detail::product_rounded_apart(n.op, of(n.a), of(n.b)));
    }
    return sum;
}

}  // namespace kagero

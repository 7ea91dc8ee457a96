/// Bounds on the rounding errors of straight-line programs, by a reverse sweep (Iri 1988). To first order, the rounding
/// error of an operation changes a result by this error times the adjoint of the operation.
#pragma once

#include "kernels/autodiff/dual.h"
#include "kernels/autodiff/interpreter.h"

namespace kagero {

/// Returns the unit in the first place of x: the greatest power of two that is not above |x| (Rump, Ogita & Oishi, SIAM
/// J. Sci. Comput. 31, 2008). The unit in the last place of x is this power times the unit in the last place of 1.
template <class V>
KAGERO_INLINE V unit_in_first_place(const V& x) {
    const V scaled = V(0x1p52 + 1) * x;
    return abs(scaled - V(1 - 0x1p-53) * scaled);
}

namespace detail {

/// Returns the product a·b of a fused operation if the instruction set has no fused operations and rounds the product
/// separately. Otherwise returns 0.
template <class V>
KAGERO_INLINE V separately_rounded_product([[maybe_unused]] Op op, [[maybe_unused]] const V& a,
                                           [[maybe_unused]] const V& b) {
#if !defined(__FMA__)
    if (info_of(op).operands == 3) return a * b;
#endif
    return V(0.0);
}

}  // namespace detail

/// Returns a bound on the effect of the rounding errors in a program on two results that depend on its outputs. The
/// unit of the bound is half a unit in the last place of 1. The bound is the sum of rounding · |adjoint| · (unit in the
/// first place of the value) over the operations, and over the products that are rounded separately. `rounding` is the
/// member of that name in operation_table.h; for a separate product it is 1. |adjoint| is the Euclidean norm of the
/// adjoints for the two results. `seeds` are the derivatives of the two results with respect to the outputs of the
/// program, one row of `outputs` numbers per result.
template <class V, class S>
V rounding_bound_of(const ProgramWithUniforms<S>& code, const V* inputs, const V* seeds, int outputs) {
    using DualNumber = Dual<V, most_operands>;
    const ProgramView& program = code.program;
    V value[Tape::capacity], adjoint[Tape::capacity][2];
    const V zero(S(0));
    // Returns the value of node k, or 0 if the operand is absent (k = −1).
    const auto operand_value = [&](int k) -> const V& { return k < 0 ? zero : value[k]; };
    evaluate(code, inputs, value);
    for (int i = 0; i < program.size; ++i) adjoint[i][0] = adjoint[i][1] = zero;
    for (int o = 0; o < outputs; ++o)
        for (int r = 0; r < 2; ++r) adjoint[program.outputs[o]][r] += seeds[r * outputs + o];
    V sum = zero;
    for (int i = program.size - 1; i >= 0; --i) {
        const Node& n = program.nodes[i];
        if (is_leaf(n.op)) continue;
        const int operands[most_operands] = {n.a, n.b, n.c};
        const V adjoint_norm = sqrt(adjoint[i][0] * adjoint[i][0] + adjoint[i][1] * adjoint[i][1]);
        // Operations without effect are skipped in each lane, because those of a blocked branch may not be finite.
        const MaskOf<V> has_no_effect = adjoint_norm <= zero;
        const DualNumber result = detail::apply_at_run_time<DualNumber>(
            n.op, DualNumber::variable(operand_value(n.a), 0), DualNumber::variable(operand_value(n.b), 1),
            DualNumber::variable(operand_value(n.c), 2));
        for (int k = 0; k < most_operands; ++k)
            for (int r = 0; r < 2 && operands[k] >= 0; ++r)
                adjoint[operands[k]][r] =
                    select(has_no_effect, adjoint[operands[k]][r],
                           fma(adjoint[i][r], result.derivative[k], adjoint[operands[k]][r]));
        sum += select(has_no_effect, zero, V(S(info_of(n.op).rounding)) * adjoint_norm * unit_in_first_place(value[i]));
        const V product = detail::separately_rounded_product(n.op, operand_value(n.a), operand_value(n.b));
        sum += select(has_no_effect, zero, adjoint_norm * unit_in_first_place(product));
    }
    return sum;
}

}  // namespace kagero

/// Bounds on the rounding errors of straight-line programs, by a reverse sweep (Iri 1988). To first order, the rounding
/// error of an operation changes a result by this error times the adjoint of the operation.
#pragma once

#include "kernels/autodiff/dual.h"
#include "kernels/autodiff/listing.h"

namespace kagero {

/// Returns the unit in the first place of x: the greatest power of two that is not above |x| (Rump, Ogita & Oishi, SIAM
/// J. Sci. Comput. 31, 2008). The unit in the last place of x is this power times that of 1.
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

/// Returns a bound on the effect of the roundings in a program on two results, in units of half a unit in the last
/// place of 1. It is Σ rounding · |adjoint| · (unit in the first place of the value) over the operations. `rounding` is
/// the bound in operation_table.h, and |adjoint| is the Euclidean norm over the two results. `seeds` are the
/// derivatives of the two results with respect to the outputs of the program, one row of `outputs` numbers per result.
template <class V, class S>
V sum_of_roundings(const ListingWithValues<S>& listed, const V* inputs, const V* seeds, int outputs) {
    using Forward = Dual<V, most_operands>;
    const Listing& program = listed.program;
    V value[Tape::capacity], adjoint[Tape::capacity][2];
    const V zero(S(0));
    const auto value_of = [&](int k) -> const V& { return k < 0 ? zero : value[k]; };
    evaluate(listed, inputs, value);
    for (int i = 0; i < program.size; ++i) adjoint[i][0] = adjoint[i][1] = zero;
    for (int o = 0; o < outputs; ++o)
        for (int r = 0; r < 2; ++r) adjoint[program.outputs[o]][r] += seeds[r * outputs + o];
    V sum = zero;
    for (int i = program.size - 1; i >= 0; --i) {
        const Node& n = program.nodes[i];
        if (detail::is_leaf(n.op)) continue;
        const int operands[most_operands] = {n.a, n.b, n.c};
        const Forward result =
            detail::applied<Forward>(n.op, Forward::variable(value_of(n.a), 0), Forward::variable(value_of(n.b), 1),
                                     Forward::variable(value_of(n.c), 2));
        for (int k = 0; k < most_operands; ++k)
            for (int r = 0; r < 2 && operands[k] >= 0; ++r)
                adjoint[operands[k]][r] = fma(adjoint[i][r], result.derivative[k], adjoint[operands[k]][r]);
        const V adjoint_norm = sqrt(adjoint[i][0] * adjoint[i][0] + adjoint[i][1] * adjoint[i][1]);
        sum += V(S(info_of(n.op).rounding)) * adjoint_norm * unit_in_first_place(value[i]);
        sum += adjoint_norm *
               unit_in_first_place(detail::separately_rounded_product(n.op, value_of(n.a), value_of(n.b)));
    }
    return sum;
}

}  // namespace kagero

/// Forward-mode differentiation for one ray, with the components of the gradient in the lanes (Satoh 2003, Fig. 8a).
/// Each node of a program has a value and a tangent: a vector of its derivatives with respect to some of the inputs,
/// called the varying inputs.
///
/// Forward-mode and reverse-mode differentiation are applied to the same simplified operations of K. The set of nodes
/// that depend on the varying inputs is computed at compile time, so that the tangents of all other nodes cost nothing.
#pragma once

#include "kernels/autodiff/program.h"
#include "kernels/simd/packed.h"

namespace kagero {
namespace detail {

/// Entry i is true if node i has a tangent: if it depends on an input in [first, last). Dependence through the step
/// function `at_least` is ignored, because its derivative is taken as 0.
template <const auto& P, int first, int last>
inline constexpr auto varying_nodes = [] {
    std::array<bool, std::size(P.nodes)> varies{};
    for (int i = 0; i < P.size; ++i) {
        const Node& n = P.nodes[i];
        if (n.op == Op::input) varies[i] = n.a >= first && n.a < last;
        else if (!is_leaf(n.op) && !n.uniform && n.op != Op::at_least)
            varies[i] = varies[n.a] || (n.b >= 0 && varies[n.b]) || (n.c >= 0 && varies[n.c]);
    }
    return varies;
}();

/// Returns the tangent of varying input k: 1 in lane k, 0 in all other lanes. The tangent is not read from a constant
/// table, because g++ 12 may replace 64 bytes of such a table by zeros.
template <class L, int k>
KAGERO_INLINE L unit_tangent() {
    using S = ScalarOf<L>;
    L l;
    const auto fill = [&l]<int... i>(std::integer_sequence<int, i...>) __attribute__((always_inline)) {
        for (int r = 0; r < ValueTraits<L>::registers; ++r) l.v[r] = typename L::Register{S(r * L::width + i == k)...};
    };
    fill(std::make_integer_sequence<int, L::width>{});
    return l;
}

/// Returns da·ta + db·tb, the tangent of an operation with the partial derivatives da and db, whose operands have the
/// tangents ta and tb. A and B are true if operand a, or b, has a tangent. The term of an operand without a tangent is
/// omitted. At least one of A and B is true.
template <bool A, bool B, class S, class L>
KAGERO_INLINE L combined(S da, const L& ta, S db, const L& tb) {
    if constexpr (A && B) return fma(L(db), tb, L(da) * ta);
    else if constexpr (A) return L(da) * ta;
    else return L(db) * tb;
}

/// Returns the tangent of a node with the value f, whose operands have the values a and b and the tangents ta, tb and
/// tc. A, B and C are true if operand a, b, or c has a tangent. At least one of them is true.
template <Op op, bool A, bool B, bool C, class S, class L>
KAGERO_INLINE L tangent(S f, S a, const L& ta, S b, const L& tb, const L& tc) {
    if constexpr (op == Op::add) {
        if constexpr (A && B) return ta + tb;
        else return A ? ta : tb;
    } else if constexpr (op == Op::sub) {
        if constexpr (A && B) return ta - tb;
        else if constexpr (A) return ta;
        else return -tb;
    } else if constexpr (op == Op::neg) {
        return -ta;
    } else if constexpr (op == Op::mul) {
        return combined<A, B>(b, ta, a, tb);
    } else if constexpr (op == Op::fma || op == Op::fnma) {
        const S sign(op == Op::fma ? 1 : -1);
        if constexpr (!C) return combined<A, B>(sign * b, ta, sign * a, tb);
        L t = tc;
        if constexpr (A) t = fma(L(sign * b), ta, t);
        if constexpr (B) t = fma(L(sign * a), tb, t);
        return t;
    } else if constexpr (op == Op::fms) {
        if constexpr (!A && !B) return -tc;
        else if constexpr (!C) return combined<A, B>(b, ta, a, tb);
        else return combined<A, B>(b, ta, a, tb) - tc;
    } else if constexpr (requires { Operation<op>::selects_a(a, b); }) {
        const bool selects_a = Operation<op>::selects_a(a, b);
        return combined<A, B>(S(selects_a), ta, S(!selects_a), tb);
    } else if constexpr (Operation<op>::operands == 2) {
        return combined<A, B>(Operation<op>::derivative_a(a, b, f), ta, Operation<op>::derivative_b(a, b, f), tb);
    } else {
        return L(Operation<op>::derivative(a, f)) * ta;
    }
}

/// Computes the value s[I] and the tangent t[I] of node I.
template <const auto& P, int I, int first, int last, class S, class L>
KAGERO_INLINE void evaluate_with_tangent(S* s, L* t, const S* uniforms, const S* inputs) {
    constexpr Node n = P.nodes[I];
    constexpr const auto& varies = varying_nodes<P, first, last>;
    evaluate<n.op, n.uniform, calls<P>(n.op)>(s, I, P.nodes[I], P.slot[I], uniforms, inputs);
    if constexpr (n.op == Op::input) {
        if constexpr (varies[I]) t[I] = unit_tangent<L, n.a - first>();
    } else if constexpr (varies[I]) {
        constexpr bool B = n.b >= 0 && varies[n.b < 0 ? 0 : n.b], C = n.c >= 0 && varies[n.c < 0 ? 0 : n.c];
        t[I] = tangent<n.op, varies[n.a], B, C>(s[I], s[n.a], t[n.a], s[n.b < 0 ? n.a : n.b],
                                                t[n.b < 0 ? 0 : n.b], t[n.c < 0 ? 0 : n.c]);
    }
}

/// Implements `run_forward`. I are the indices of all nodes, and O those of all outputs.
template <const auto& P, int first, int last, class S, class L, int... I, int... O>
KAGERO_INLINE void run_forward(const S* uniforms, const S* inputs, L* tangents, std::integer_sequence<int, I...>,
                               std::integer_sequence<int, O...>) {
    constexpr const auto& varies = varying_nodes<P, first, last>;
    S s[sizeof...(I) + 1];
    L t[sizeof...(I) + 1];
    (evaluate_with_tangent<P, I, first, last>(s, t, uniforms, inputs), ...);
    const auto output_tangent = [&]<int node>() __attribute__((always_inline)) -> L {
        if constexpr (varies[node]) return t[node];
        else return L(S(0));
    };
    ((tangents[O] = output_tangent.template operator()<P.outputs[O]>()), ...);
}

}  // namespace detail

/// Computes the derivatives of every output of program P with respect to the inputs [first, last). Lane k of
/// tangents[o] is ∂(output o)/∂(input first + k).
template <const auto& P, int first, int last, class S>
KAGERO_INLINE void run_forward(const S* uniforms, const S* inputs, Packed<S, last - first>* tangents) {
    detail::run_forward<P, first, last>(uniforms, inputs, tangents, std::make_integer_sequence<int, P.size>{},
                                        std::make_integer_sequence<int, static_cast<int>(P.outputs.size())>{});
}

}  // namespace kagero

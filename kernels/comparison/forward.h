/// Forward-mode differentiation of one ray with the components of its gradient in the lanes (Satoh 2003, Fig. 8a):
/// beside its value every node of a program carries its derivatives along all varying inputs, as one packed vector.
///
/// It runs over the simplified program of H that the reverse sweep starts from too. What a node does not depend on
/// costs nothing: which nodes vary is known to the compiler.
#pragma once

#include "kernels/autodiff/program.h"

namespace kagero {
namespace detail {

/// As many registers as n numbers take.
template <class S, int n>
inline constexpr int registers_for = n <= Lanes<S, 1>::width ? 1 : n <= 2 * Lanes<S, 1>::width ? 2 : 4;

}  // namespace detail

/// n numbers of one ray side by side, and perhaps some lanes too many.
template <class S, int n>
using Packed = Lanes<S, detail::registers_for<S, n>>;

namespace detail {

/// Whether node i depends on an input in [first, last).
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

/// The tangent of input k: 1 in lane k, else 0. Not from a table: g++ 12 takes 64 bytes of a constant one for zeros.
template <class L, int k>
KAGERO_INLINE L unit() {
    using S = ScalarOf<L>;
    L l;
    const auto fill = [&l]<int... i>(std::integer_sequence<int, i...>) __attribute__((always_inline)) {
        for (int r = 0; r < ValueTraits<L>::registers; ++r) l.v[r] = typename L::Register{S(r * L::width + i == k)...};
    };
    fill(std::make_integer_sequence<int, L::width>{});
    return l;
}

/// da·ta + db·tb over those of the two that vary.
template <bool A, bool B, class S, class L>
KAGERO_INLINE L combined(S da, const L& ta, S db, const L& tb) {
    if constexpr (A && B) return fma(L(db), tb, L(da) * ta);
    else if constexpr (A) return L(da) * ta;
    else return L(db) * tb;
}

/// The tangent of a node from those of its operands; A, B, C: which of them vary.
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
    } else if constexpr (requires { Operation<op>::first(a, b); }) {
        const bool first = Operation<op>::first(a, b);
        return combined<A, B>(S(first), ta, S(!first), tb);
    } else if constexpr (Operation<op>::operands == 2) {
        return combined<A, B>(Operation<op>::derivative_a(a, b, f), ta, Operation<op>::derivative_b(a, b, f), tb);
    } else {
        return L(Operation<op>::derivative(a, f)) * ta;
    }
}

template <const auto& P, int I, int first, int last, class S, class L>
KAGERO_INLINE void sweep(S* s, L* t, const S* uniforms, const S* inputs) {
    constexpr Node n = P.nodes[I];
    constexpr const auto& varies = varying_nodes<P, first, last>;
    evaluate<n.op, n.uniform, calls<P>(n.op)>(s, I, P.nodes[I], P.slot[I], uniforms, inputs);
    if constexpr (n.op == Op::input) {
        if constexpr (varies[I]) t[I] = unit<L, n.a - first>();
    } else if constexpr (varies[I]) {
        constexpr bool B = n.b >= 0 && varies[n.b < 0 ? 0 : n.b], C = n.c >= 0 && varies[n.c < 0 ? 0 : n.c];
        t[I] = tangent<n.op, varies[n.a], B, C>(s[I], s[n.a], t[n.a], s[n.b < 0 ? n.a : n.b],
                                                t[n.b < 0 ? 0 : n.b], t[n.c < 0 ? 0 : n.c]);
    }
}

template <const auto& P, int first, int last, class S, class L, int... I, int... O>
KAGERO_INLINE void run_forward(const S* uniforms, const S* inputs, L* tangents, std::integer_sequence<int, I...>,
                               std::integer_sequence<int, O...>) {
    constexpr const auto& varies = varying_nodes<P, first, last>;
    S s[sizeof...(I) + 1];
    L t[sizeof...(I) + 1];
    (sweep<P, I, first, last>(s, t, uniforms, inputs), ...);
    const auto of_output = [&]<int place>() __attribute__((always_inline)) -> L {
        if constexpr (varies[place]) return t[place];
        else return L(S(0));
    };
    ((tangents[O] = of_output.template operator()<P.outputs[O]>()), ...);
}

}  // namespace detail

/// The derivatives of every output of program P along inputs first … last − 1: lane k of tangents[o] is ∂output
/// o/∂input (first + k).
template <const auto& P, int first, int last, class S>
KAGERO_INLINE void run_forward(const S* uniforms, const S* inputs, Packed<S, last - first>* tangents) {
    detail::run_forward<P, first, last>(uniforms, inputs, tangents, std::make_integer_sequence<int, P.size>{},
                                        std::make_integer_sequence<int, static_cast<int>(P.outputs.size())>{});
}

}  // namespace kagero

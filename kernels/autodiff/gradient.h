/// The reverse sweep: derivatives of a node of a tape, recorded onto the same tape.
#pragma once

#include "kernels/autodiff/recorded.h"

#include <array>

namespace kagero {

namespace detail {

/// Gives the operands of the function at node i of the tape d times its derivatives. The first derivative is given
/// before the second is recorded.
template <Op op, class Give>
constexpr void give_by_derivatives(Tape& t, int i, int d, const Give& give) {
    using F = Operation<op>;
    const int to_a = t.nodes[i].a, to_b = t.nodes[i].b;
    const Recorded a(&t, to_a), b(&t, to_b), y(&t, i), dy(&t, d);
    if constexpr (requires { F::first(a, b); }) {
        const Recorded first = F::first(a, b);
        give(to_a, (dy * first).node), give(to_b, (dy * (1.0 - first)).node);
    } else if constexpr (requires { F::adjoint(dy, a, y); }) {
        give(to_a, F::adjoint(dy, a, y).node);
    } else if constexpr (requires { F::adjoint_a(dy, a, b, y); }) {
        give(to_a, F::adjoint_a(dy, a, b, y).node), give(to_b, F::adjoint_b(dy, a, b, y).node);
    } else if constexpr (requires { F::derivative(a, y); }) {
        give(to_a, (dy * F::derivative(a, y)).node);
    } else if constexpr (requires { F::derivative_a(a, b, y); }) {
        give(to_a, (dy * F::derivative_a(a, b, y)).node), give(to_b, (dy * F::derivative_b(a, b, y)).node);
    }
}

}  // namespace detail

/// Gives the operands of the operation at node i of the tape their shares of its derivative, node d, by
/// `give(operand, share)`.
template <class Give>
constexpr void give_operands(Tape& t, int i, int d, const Give& give) {
    const Node n = t.nodes[i];
    switch (n.op) {
        case Op::add: give(n.a, d), give(n.b, d); break;
        case Op::sub: give(n.a, d), give(n.b, t.neg(d)); break;
        case Op::mul:
            if (const int root = t.root_of(i); root >= 0) {
                // √s, written s·(1/√s): half of 1/√s, not a difference of two large terms.
                give(t.nodes[root].a, t.mul(t.constant(0.5), t.mul(d, root)));
            } else if (n.a == n.b) {
                give(n.a, t.mul(t.mul(t.constant(2), d), n.a));
            } else {
                give(n.a, t.mul(d, n.b)), give(n.b, t.mul(d, n.a));
            }
            break;
        case Op::neg: give(n.a, t.neg(d)); break;
#define KAGERO_OPERATION(OP, OPERATION) case Op::OP: detail::give_by_derivatives<Op::OP>(t, i, d, give); break;
        KAGERO_FUNCTIONS(KAGERO_OPERATION)
#undef KAGERO_OPERATION
        default: break;  // leaves have no operands; fused operations appear only after recording
    }
}

/// Adds to the tape the derivatives of node `output` with respect to the leaves `wanted`, inputs or parameters;
/// `gradient[k]` receives their nodes. Branches that do not reach a wanted leaf cost nothing.
template <int N>
constexpr void record_gradient(Tape& t, int output, const std::array<int, N>& wanted, std::array<int, N>& gradient) {
    const int last = output;
    bool reaches[Tape::capacity]{};
    int adjoint[Tape::capacity]{};
    for (int i = 0; i <= last; ++i) {
        const Node& n = t.nodes[i];
        if (n.op == Op::input || n.op == Op::parameter) {
            for (int w : wanted) reaches[i] = reaches[i] || w == i;
        } else if (n.op != Op::constant) {
            reaches[i] = reaches[n.a] || (n.b >= 0 && reaches[n.b]);
        }
        adjoint[i] = -1;
    }
    const auto give = [&](int to, int amount) {
        if (reaches[to]) adjoint[to] = adjoint[to] < 0 ? amount : t.add(adjoint[to], amount);
    };
    adjoint[last] = t.constant(1);
    for (int i = last; i >= 0; --i) {
        const int d = adjoint[i];
        if (d < 0 || !reaches[i]) continue;
        give_operands(t, i, d, give);
    }
    for (int k = 0; k < N; ++k) {
        const bool is_zero = wanted[k] > last || adjoint[wanted[k]] < 0;
        gradient[k] = is_zero ? t.constant(0) : adjoint[wanted[k]];
    }
}

/// The node of g·h with g multiplied through: distributed over sums that have a term with the factor 1/g, where it
/// cancels.
constexpr int multiply_through(Tape& t, int g, int h) {
    const int one_over = t.recip(g);
    const auto factor = [&](auto&& self, int i) -> bool {
        const Node& n = t.nodes[i];
        return i == one_over || (n.op == Op::mul && (self(self, n.a) || self(self, n.b)));
    };
    const auto term = [&](auto&& self, int i) -> bool {
        const Node& n = t.nodes[i];
        if (n.op == Op::neg) return self(self, n.a);
        if (n.op == Op::add || n.op == Op::sub) return self(self, n.a) || self(self, n.b);
        return factor(factor, i);
    };
    const Node n = t.nodes[h];
    if (h == one_over) return t.constant(1);
    if (!term(term, h)) return t.mul(g, h);
    switch (n.op) {
        case Op::add: return t.add(multiply_through(t, g, n.a), multiply_through(t, g, n.b));
        case Op::sub: return t.sub(multiply_through(t, g, n.a), multiply_through(t, g, n.b));
        case Op::neg: return t.neg(multiply_through(t, g, n.a));
        default: break;  // a product
    }
    return factor(factor, n.a) ? t.mul(multiply_through(t, g, n.a), n.b) : t.mul(n.a, multiply_through(t, g, n.b));
}

}  // namespace kagero

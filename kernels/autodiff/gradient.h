/// Reverse-mode differentiation of a node of a tape. The derivatives are recorded onto the same tape.
///
/// The adjoint of node i is ∂output/∂(node i). The nodes are visited from last to first. When node i is visited, the
/// contribution adjoint(i)·∂(node i)/∂(operand) is added to the adjoint of each of its operands.
#pragma once

#include "kernels/autodiff/recorded.h"

#include <array>

namespace kagero {

namespace detail {

/// Implements `propagate_adjoint` for nodes whose operation is in KAGERO_FUNCTIONS (operation_table.h). Functions
/// without a derivative, such as `at_least`, contribute nothing. The order of the calls of `accumulate` must not be
/// changed, because it determines the order of the recorded nodes.
template <Op op, class Accumulate>
constexpr void propagate_through_function(Tape& t, int i, int d, const Accumulate& accumulate) {
    using F = Operation<op>;
    const int node_a = t.nodes[i].a, node_b = t.nodes[i].b;
    const Recorded a(&t, node_a), b(&t, node_b), y(&t, i), adjoint(&t, d);
    if constexpr (requires { F::selects_a(a, b); }) {
        const Recorded a_selected = F::selects_a(a, b);  // 1 if node i equals a, 0 if it equals b
        accumulate(node_a, (adjoint * a_selected).node);
        accumulate(node_b, (adjoint * (1.0 - a_selected)).node);
    } else if constexpr (requires { F::adjoint(adjoint, a, y); }) {
        accumulate(node_a, F::adjoint(adjoint, a, y).node);
    } else if constexpr (requires { F::adjoint_a(adjoint, a, b, y); }) {
        accumulate(node_a, F::adjoint_a(adjoint, a, b, y).node);
        accumulate(node_b, F::adjoint_b(adjoint, a, b, y).node);
    } else if constexpr (requires { F::derivative(a, y); }) {
        accumulate(node_a, (adjoint * F::derivative(a, y)).node);
    } else if constexpr (requires { F::derivative_a(a, b, y); }) {
        accumulate(node_a, (adjoint * F::derivative_a(a, b, y)).node);
        accumulate(node_b, (adjoint * F::derivative_b(a, b, y)).node);
    }
}

}  // namespace detail

/// Records d·∂(node i)/∂(operand) for each operand of node i, where node d is the adjoint of node i. Calls
/// `accumulate(operand, contribution)`, where `contribution` is the recorded node.
template <class Accumulate>
constexpr void propagate_adjoint(Tape& t, int i, int d, const Accumulate& accumulate) {
    const Node n = t.nodes[i];
    switch (n.op) {
        case Op::add:
            accumulate(n.a, d);
            accumulate(n.b, d);
            break;
        case Op::sub:
            accumulate(n.a, d);
            accumulate(n.b, t.neg(d));
            break;
        case Op::mul:
            if (const int reciprocal_root = t.reciprocal_root_of(i); reciprocal_root >= 0) {
                // Node i is √s, recorded as s·(1/√s). Its derivative is recorded as ½·(1/√s); the product rule would
                // give a difference of two terms.
                accumulate(t.nodes[reciprocal_root].a, t.mul(t.constant(0.5), t.mul(d, reciprocal_root)));
            } else if (n.a == n.b) {
                accumulate(n.a, t.mul(t.mul(t.constant(2), d), n.a));
            } else {
                accumulate(n.a, t.mul(d, n.b));
                accumulate(n.b, t.mul(d, n.a));
            }
            break;
        case Op::neg: accumulate(n.a, t.neg(d)); break;
#define KAGERO_OPERATION(OP, OPERATION) \
    case Op::OP: detail::propagate_through_function<Op::OP>(t, i, d, accumulate); break;
        KAGERO_FUNCTIONS(KAGERO_OPERATION)
#undef KAGERO_OPERATION
        default: break;  // leaves, which have no operands; tapes contain no fused operations
    }
}

namespace detail {

/// Reverse sweeps that record the derivatives of nodes with respect to N leaves, which are inputs or parameters.
template <int N>
class GradientSweep {
public:
    /// Derivatives are recorded for nodes whose index is at most `last`.
    constexpr GradientSweep(Tape& t, const std::array<int, N>& leaves, int last) : t_(t), leaves_(leaves) {
        for (int i = 0; i <= last; ++i) {
            const Node& n = t.nodes[i];
            if (n.op == Op::input || n.op == Op::parameter) {
                for (int leaf : leaves) depends_on_leaves_[i] = depends_on_leaves_[i] || leaf == i;
            } else if (n.op != Op::constant) {
                depends_on_leaves_[i] = depends_on_leaves_[n.a] || (n.b >= 0 && depends_on_leaves_[n.b]);
            }
        }
    }

    /// Records the derivatives of node `output` and returns their nodes.
    constexpr std::array<int, N> derivatives_of(int output) {
        int adjoint[Tape::capacity]{};  // for each node, the node of its adjoint; −1 if it has no contribution yet
        for (int i = 0; i <= output; ++i) adjoint[i] = -1;
        const auto accumulate = [&](int operand, int contribution) {
            if (!depends_on_leaves_[operand]) return;
            int& sum = adjoint[operand];
            sum = sum < 0 ? contribution : t_.add(sum, contribution);
        };
        adjoint[output] = t_.constant(1);
        for (int i = output; i >= 0; --i) {
            if (adjoint[i] < 0 || !depends_on_leaves_[i]) continue;
            if (is_gate(t_.nodes[i].op)) propagate_through_gate(i, adjoint[i], accumulate);
            else propagate_adjoint(t_, i, adjoint[i], accumulate);
        }
        std::array<int, N> gradient{};
        for (int k = 0; k < N; ++k) {
            const bool is_zero = leaves_[k] > output || adjoint[leaves_[k]] < 0;
            gradient[k] = is_zero ? t_.constant(0) : adjoint[leaves_[k]];
        }
        return gradient;
    }

private:
    /// Records the contribution of the gate at node i, whose adjoint is node d, to the adjoints of the leaves. The
    /// operand is differentiated in a sweep of its own, and the gate blocks the result. If the adjoint 0 of a blocked
    /// operand went through the same sweep, it would be multiplied by derivatives that may be infinite or NaN.
    template <class Accumulate>
    constexpr void propagate_through_gate(int i, int d, const Accumulate& accumulate) {
        const Node gate = t_.nodes[i];
        if (!depends_on_leaves_[gate.b]) return;
        const std::array<int, N> derivatives = derivatives_of(gate.b);
        const int zero = t_.constant(0);
        for (int k = 0; k < N; ++k)
            if (derivatives[k] != zero) accumulate(leaves_[k], t_.mul(d, t_.binary(gate.op, gate.a, derivatives[k])));
    }

    Tape& t_;
    const std::array<int, N>& leaves_;
    bool depends_on_leaves_[Tape::capacity]{};
};

}  // namespace detail

/// Records the derivatives of node `output` with respect to the nodes `leaves`, which are inputs or parameters. Writes
/// the nodes of the derivatives to `gradient`.
template <int N>
constexpr void record_gradient(Tape& t, int output, const std::array<int, N>& leaves, std::array<int, N>& gradient) {
    gradient = detail::GradientSweep<N>(t, leaves, output).derivatives_of(output);
}

/// Records the product of the nodes g and h and returns its node. If h has the factor 1/g, this factor is omitted
/// instead. If h is a sum with such a term, each term of the sum is multiplied by g.
constexpr int multiply_through(Tape& t, int g, int h) {
    const int reciprocal = t.recip(g);
    // Returns true if node i has the factor 1/g.
    const auto has_factor = [&](auto&& self, int i) -> bool {
        const Node& n = t.nodes[i];
        return i == reciprocal || (n.op == Op::mul && (self(self, n.a) || self(self, n.b)));
    };
    // Returns true if node i, or a term of the sum at node i, has the factor 1/g.
    const auto has_term_with_factor = [&](auto&& self, int i) -> bool {
        const Node& n = t.nodes[i];
        if (n.op == Op::neg) return self(self, n.a);
        if (n.op == Op::add || n.op == Op::sub) return self(self, n.a) || self(self, n.b);
        return has_factor(has_factor, i);
    };
    const Node n = t.nodes[h];
    if (h == reciprocal) return t.constant(1);
    if (!has_term_with_factor(has_term_with_factor, h)) return t.mul(g, h);
    switch (n.op) {
        case Op::add: return t.add(multiply_through(t, g, n.a), multiply_through(t, g, n.b));
        case Op::sub: return t.sub(multiply_through(t, g, n.a), multiply_through(t, g, n.b));
        case Op::neg: return t.neg(multiply_through(t, g, n.a));
        default: break;  // h is a product
    }
    return has_factor(has_factor, n.a) ? t.mul(multiply_through(t, g, n.a), n.b)
                                       : t.mul(n.a, multiply_through(t, g, n.b));
}

}  // namespace kagero

/// Forward-mode differentiation of a node of a tape. The tangents are recorded onto the same tape.
///
/// The tangent of node i is Σ_k ∂(node i)/∂(leaf k)·(seed k). If seed k is the unit vector of lane k, then lane k of
/// the tangent is the derivative with respect to leaf k.
#pragma once

#include "kernels/autodiff/arrange.h"
#include "kernels/autodiff/gradient.h"

namespace kagero {
namespace detail {

/// Records the tangent of node i and returns its node; −1 if it is 0. `tangent` contains those of the earlier nodes.
/// The product of a tangent and a derivative is recorded by the rules of the reverse mode, with the tangent of an
/// operand in place of the adjoint.
constexpr int record_tangent_of_node(Tape& t, int i, const int (&tangent)[Tape::capacity]) {
    const Node n = t.nodes[i];
    if (is_leaf(n.op)) return -1;
    if (is_gate(n.op)) return tangent[n.b] < 0 ? -1 : t.binary(n.op, n.a, tangent[n.b]);
    int sum = -1;
    for (const int operand : {n.a, n.b != n.a ? n.b : -1}) {
        if (operand < 0 || tangent[operand] < 0) continue;
        propagate_adjoint(t, i, tangent[operand], [&](int to, int contribution) {
            if (to == operand) sum = sum < 0 ? contribution : t.add(sum, contribution);
        });
    }
    return sum;
}

}  // namespace detail

/// Records the tangent of node `output` and returns its node. `leaves` and `seeds` are `count` nodes each.
constexpr int record_tangent(Tape& t, int output, const int* leaves, const int* seeds, int count) {
    bool needed[Tape::capacity]{};
    int tangent[Tape::capacity]{};
    needed[output] = true;
    for (int i = output; i >= 0; --i) {
        const Node& n = t.nodes[i];
        if (!needed[i] || is_leaf(n.op)) continue;
        needed[n.a] = true;
        if (n.b >= 0) needed[n.b] = true;
    }
    for (int i = 0; i <= output && !t.full; ++i) {
        tangent[i] = needed[i] ? detail::record_tangent_of_node(t, i, tangent) : -1;
        for (int k = 0; k < count; ++k)
            if (leaves[k] == i) tangent[i] = seeds[k];
    }
    return tangent[output] < 0 ? t.constant(0) : tangent[output];
}

}  // namespace kagero

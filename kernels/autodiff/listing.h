/// Straight-line programs as data, which an interpreter evaluates node by node. They are used for computations that are
/// too rare to be compiled for every Hamiltonian.
#pragma once

#include "kernels/autodiff/dual.h"
#include "kernels/autodiff/program.h"

namespace kagero {

/// A program as data, without its uniforms.
struct Listing {
    const Node* nodes;
    const int* slots;  ///< For each uniform node, its index in the table of uniforms.
    const int* outputs;
    int size;
};

/// A program as data, with its uniforms.
template <class S>
struct ListingWithValues {
    Listing program;
    const S* uniforms;
};

/// Uninitialized memory for the values of the nodes of a program.
template <class V>
struct NodeValues {
    alignas(V) unsigned char memory[sizeof(V) * Tape::capacity];
    V* data() { return reinterpret_cast<V*>(memory); }
};

/// Evaluates a program and writes the value of each node i to value[i]. V must be constructible from S.
template <class V, class S>
void evaluate(const ListingWithValues<S>& listed, const V* inputs, V* value) {
    const V zero(S(0));
    const auto operand = [&](int k) -> const V& { return k < 0 ? zero : value[k]; };
    for (int i = 0; i < listed.program.size; ++i) {
        const Node& n = listed.program.nodes[i];
        if (n.op == Op::input) value[i] = inputs[n.a];
        else if (n.op == Op::constant) value[i] = V(S(n.value));
        else if (n.op == Op::parameter) value[i] = V(listed.uniforms[listed.program.slots[i]]);
        else value[i] = detail::applied<V>(n.op, operand(n.a), operand(n.b), operand(n.c));
    }
}

/// Computes the outputs of a program, and their derivatives with respect to its first `entries` / `outputs` inputs. The
/// derivatives are a matrix with one row per output. The program is evaluated once for every three of these inputs,
/// with dual numbers that have three derivatives.
template <class V, class S, int inputs, int outputs, int entries>
void differentiate(const ListingWithValues<S>& listed, const V (&at)[inputs], V (&values)[outputs],
                   V (&derivatives)[entries]) {
    constexpr int variables = entries / outputs, together = 3;
    static_assert(variables * outputs == entries && variables <= inputs && variables % together == 0);
    using Forward = Dual<V, together>;
    NodeValues<Forward> memory;
    for (int from = 0; from < variables; from += together) {
        Forward in[inputs];
        for (int k = 0; k < inputs; ++k)
            in[k] = k >= from && k < from + together ? Forward::variable(at[k], k - from) : Forward(at[k]);
        evaluate(listed, in, memory.data());
        for (int i = 0; i < outputs; ++i) {
            const Forward& g = memory.data()[listed.program.outputs[i]];
            values[i] = g.value;
            for (int k = 0; k < together; ++k) derivatives[variables * i + from + k] = g.derivative[k];
        }
    }
}

}  // namespace kagero

/// Straight-line programs as data: what is not worth compiling for every Hamiltonian is interpreted, operation by
/// operation.
#pragma once

#include "kernels/autodiff/dual.h"
#include "kernels/autodiff/program.h"

namespace kagero {

/// A program as data.
struct Listing {
    const Node* nodes;
    const int* slots;  ///< of uniform nodes in the table of uniforms
    const int* outputs;
    int size;
};

/// A program as data, with its uniforms.
template <class S>
struct Listed {
    Listing program;
    const S* uniforms;
};

/// Room for the value of every node, which nobody fills before its time.
template <class V>
struct Values {
    alignas(V) unsigned char memory[sizeof(V) * Tape::capacity];
    V* data() { return reinterpret_cast<V*>(memory); }
};

/// The values of all nodes, in numbers of any type that an S can become.
template <class V, class S>
void evaluate(const Listed<S>& listed, const V* inputs, V* value) {
    const V zero(S(0));
    const auto of = [&](int k) -> const V& { return k < 0 ? zero : value[k]; };
    for (int i = 0; i < listed.program.size; ++i) {
        const Node& n = listed.program.nodes[i];
        if (n.op == Op::input) value[i] = inputs[n.a];
        else if (n.op == Op::constant) value[i] = V(S(n.value));
        else if (n.op == Op::parameter) value[i] = V(listed.uniforms[listed.program.slots[i]]);
        else value[i] = detail::applied<V>(n.op, of(n.a), of(n.b), of(n.c));
    }
}

/// The outputs of a program and their derivatives by its first inputs, one row per output: forward duals, a few inputs
/// at a time.
template <class V, class S, int inputs, int outputs, int entries>
void differentiate(const Listed<S>& listed, const V (&at)[inputs], V (&values)[outputs], V (&derivatives)[entries]) {
    constexpr int variables = entries / outputs, together = 3;
    static_assert(variables * outputs == entries && variables <= inputs && variables % together == 0);
    using Forward = Dual<V, together>;
    Values<Forward> memory;
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

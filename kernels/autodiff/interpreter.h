/// Interpreter for straight-line programs. It reads the nodes of a program as data, and is used for computations that
/// are too rare to be compiled for every Hamiltonian.
#pragma once

#include "kernels/autodiff/dual.h"
#include "kernels/autodiff/program.h"

namespace kagero {

/// The arrays of a program (see `Program`).
struct ProgramView {
    const Node* nodes;
    /// For each uniform node, its index in the table of uniforms. May be null if the program has no parameters.
    const int* slots;
    const int* outputs;
    int size;
};

/// The arrays of a program and its table of uniforms.
template <class S>
struct ProgramWithUniforms {
    ProgramView program;
    const S* uniforms;  ///< May be null if the program has no parameters.
};

/// Uninitialized memory for the values of all nodes of a program.
template <class V>
struct NodeValues {
    alignas(V) unsigned char memory[sizeof(V) * Tape::capacity];
    V* data() { return reinterpret_cast<V*>(memory); }
};

/// Evaluates a program and writes the value of each node i to value[i]. Only the values of parameters are read from the
/// table of uniforms; the other uniform nodes are evaluated again. V must be constructible from S.
template <class V, class S>
void evaluate(const ProgramWithUniforms<S>& code, const V* inputs, V* value) {
    const V zero(S(0));
    // Returns the value of node k, or 0 if the operand is absent (k = −1).
    const auto operand = [&](int k) -> const V& { return k < 0 ? zero : value[k]; };
    for (int i = 0; i < code.program.size; ++i) {
        const Node& n = code.program.nodes[i];
        if (n.op == Op::input) value[i] = inputs[n.a];
        else if (n.op == Op::constant) value[i] = V(S(n.value));
        else if (n.op == Op::parameter) value[i] = V(code.uniforms[code.program.slots[i]]);
        else value[i] = detail::apply_at_run_time<V>(n.op, operand(n.a), operand(n.b), operand(n.c));
    }
}

/// Computes the outputs of a program for the inputs `point`, and their derivatives with respect to the first n inputs.
/// `derivatives` is a matrix of `outputs` rows and n columns, stored row by row; n is `entries` / `outputs`. The
/// program is evaluated n/3 times, each time with dual numbers that have three derivatives.
template <class V, class S, int inputs, int outputs, int entries>
void differentiate(const ProgramWithUniforms<S>& code, const V (&point)[inputs], V (&values)[outputs],
                   V (&derivatives)[entries]) {
    constexpr int variables = entries / outputs, per_evaluation = 3;  // `variables` is n
    static_assert(variables * outputs == entries && variables <= inputs && variables % per_evaluation == 0);
    using DualNumber = Dual<V, per_evaluation>;
    NodeValues<DualNumber> memory;
    for (int first = 0; first < variables; first += per_evaluation) {
        DualNumber in[inputs];
        for (int k = 0; k < inputs; ++k) {
            const bool is_variable = k >= first && k < first + per_evaluation;
            in[k] = is_variable ? DualNumber::variable(point[k], k - first) : DualNumber(point[k]);
        }
        evaluate(code, in, memory.data());
        for (int i = 0; i < outputs; ++i) {
            const DualNumber& result = memory.data()[code.program.outputs[i]];
            values[i] = result.value;
            for (int k = 0; k < per_evaluation; ++k) derivatives[variables * i + first + k] = result.derivative[k];
        }
    }
}

}  // namespace kagero

/// Numbers of floating-point operations of programs. They are lower bounds, from `flops` in operation_table.h.
#pragma once

#include "kernels/autodiff/program.h"

namespace kagero {

/// Returns the number of floating-point operations of one operation of the table.
constexpr double operations_of(Op op) { return info_of(op).flops; }

/// Returns the number of floating-point operations of one evaluation of a program. Uniform nodes are not counted,
/// because they are evaluated once per job.
template <int Size, int Outputs>
constexpr double operations_of(const Program<Size, Outputs>& program) {
    double sum = 0;
    for (int k = 0; k < program.size; ++k)
        if (!program.nodes[k].uniform) sum += operations_of(program.nodes[k].op);
    return sum;
}

/// Numbers of floating-point operations of the programs of a Hamiltonian K, per evaluation.
struct ProgramOperations {
    double derivatives;      ///< ∂K/∂q and ∂K/∂p
    double force;            ///< ∂K/∂q
    double velocity;         ///< ∂K/∂p
    double event_functions;  ///< the functions of struct EventFunctions
    double slope = 0;        ///< ∂V/∂u of the orbit potential V(u); 0 if H has no orbit potential
};

}  // namespace kagero

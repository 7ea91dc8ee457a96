/// Numbers of floating-point operations of programs: sums of `flops` in operation_table.h, which are lower bounds.
#pragma once

#include "kernels/autodiff/program.h"

namespace kagero {

/// Returns the number of floating-point operations of one operation of operation_table.h.
constexpr double flops_of(Op op) { return info_of(op).flops; }

/// Returns the number of floating-point operations of one evaluation of a program. Uniform nodes are not counted,
/// because they are evaluated once per job.
template <int Size, int Outputs>
constexpr double flops_of(const Program<Size, Outputs>& program) {
    double sum = 0;
    for (int k = 0; k < program.size; ++k)
        if (!program.nodes[k].uniform) sum += flops_of(program.nodes[k].op);
    return sum;
}

/// Numbers of floating-point operations per evaluation of the programs that are extracted from the tape of a space.
struct ProgramOperations {
    double derivatives;      ///< ∂K/∂q and ∂K/∂p
    double force;            ///< ∂K/∂q
    double velocity;         ///< ∂K/∂p
    double event_functions;  ///< the functions of struct EventFunctions
    /// ∂V/∂u, where V(u) is the potential of the motion in the orbit plane, and u = 1/r; 0 if H declares no potential.
    double potential_slope = 0;
};

}  // namespace kagero

/// Floating-point operations of programs: lower bounds, as the table of operations states them.
#pragma once

#include "kernels/autodiff/program.h"

namespace kagero {

constexpr double operations_of(Op op) { return info_of(op).flops; }

/// The operations of one run. Nodes that depend on parameters alone do not count: they are evaluated once per job.
template <int Size, int Outputs>
constexpr double operations_of(const Program<Size, Outputs>& program) {
    double sum = 0;
    for (int k = 0; k < program.size; ++k)
        if (!program.nodes[k].uniform) sum += operations_of(program.nodes[k].op);
    return sum;
}

/// The operations of each program of a Hamiltonian that methods run.
struct ProgramOperations {
    double derivatives, force, velocity, event_functions;
    double slope = 0;  ///< ∂V/∂u in the plane of an orbit, where it is stated
};

}  // namespace kagero

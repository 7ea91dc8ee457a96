/// Floating-point operations of programs. Lower bounds: products, sums, quotients, roots, functions, minima and maxima count one each,
/// fused ones two; comparisons, signs and masks count nothing.
#pragma once

#include "kernels/autodiff/program.h"

namespace kagero {

constexpr double operations_of(Op op) {
    switch (op) {
        case Op::constant: case Op::parameter: case Op::input: case Op::neg: case Op::at_least: return 0;
        case Op::mul_add: case Op::mul_sub: case Op::neg_mul_add: return 2;
        default: return 1;
    }
}

/// Of one run; what depends on parameters alone is done once per job.
template <int Size, int Outputs>
constexpr double operations_of(const Program<Size, Outputs>& program) {
    double sum = 0;
    for (int k = 0; k < program.size; ++k)
        if (!program.nodes[k].uniform) sum += operations_of(program.nodes[k].op);
    return sum;
}

/// Of the programs of a Hamiltonian that methods run.
struct ProgramOperations {
    double derivatives, force, velocity, survey;
    double slope = 0;  ///< ∂V/∂u in the plane of an orbit, where it is stated
};

}  // namespace kagero

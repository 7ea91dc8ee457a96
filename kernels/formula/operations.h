/// Number of floating-point operations of a formula's code, for the costs in kernels/integrators/costs.h.
#pragma once

#include "kernels/formula/code.h"
#include "kernels/autodiff/operations.h"

namespace kagero::formula {

/// Returns the number of floating-point operations of one instruction.
inline double flops_of(std::uint8_t opcode) {
    if (opcode >= opcode_of(AccumulatorOp::fma)) return 2;
    return opcode >= opcode_of(AccumulatorOp::add) ? 1 : kagero::flops_of(static_cast<Op>(opcode));
}

/// Returns the number of floating-point operations of one evaluation of a code.
inline double flops_of(const Code& code) {
    double sum = 0;
    for (int r = 0; r < code.runs; ++r) sum += code.run[r].count * flops_of(code.run[r].opcode);
    return sum;
}

}  // namespace kagero::formula

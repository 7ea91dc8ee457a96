/// How many floating-point operations a formula's program costs: kernels/integrators/costs.h, for programs that are
/// data.
#pragma once

#include "kernels/formula/code.h"
#include "kernels/autodiff/operations.h"

namespace kagero::formula {

inline double operations_of(std::uint8_t kind) {
    if (kind >= kind_of(OnLast::fma)) return 2;
    return kind >= kind_of(OnLast::add) ? 1 : kagero::operations_of(static_cast<Op>(kind));
}

inline double operations_of(const Code& code) {
    double sum = 0;
    for (int r = 0; r < code.runs; ++r) sum += code.run[r].count * operations_of(code.run[r].kind);
    return sum;
}

}  // namespace kagero::formula

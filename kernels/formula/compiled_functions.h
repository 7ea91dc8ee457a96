/// The functions of a formula that can be compiled to machine code.
#pragma once

#include "kernels/code_generation.h"
#include "kernels/formula/programs.h"

namespace kagero::formula {

/// Implement FormulaFunctions.
void describe_functions(const double* programs, void* user, FunctionSink sink);
void use_functions(double* programs, const CompiledFunction* functions);
void set_parameters(double* programs, const double* values);

}  // namespace kagero::formula

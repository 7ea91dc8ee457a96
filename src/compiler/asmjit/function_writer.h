/// Machine code of one function.
#pragma once

#include "kernels/code_generation.h"

#include <asmjit/x86.h>

namespace kagero::compiler {

/// Writes a function, whose type is CompiledFunction: a loop over points. The program is
/// written once, without branches.
void write_function(asmjit::x86::Assembler& assembler, const FunctionDescription& function);

}  // namespace kagero::compiler

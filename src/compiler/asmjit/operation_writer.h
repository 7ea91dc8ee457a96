/// Machine code of single operations.
#pragma once

#include "compiler/asmjit/register_file.h"

namespace kagero::compiler {

/// Writes the code of the nodes of one function, one after the other. The roundings and the results for 0, ∞ and NaN
/// are those of the interpreter. Operations that have no code here are calls of the functions of the value type, so
/// that a new row of the operation table needs no change.
class OperationWriter {
public:
    OperationWriter(x86::Assembler& assembler, VectorAssembler& vectors, RegisterFile& registers,
                    const UnrolledProgram& program)
        : a_(assembler), v_(vectors), r_(registers), program_(program) {}

    /// Writes the code of a node, and of those that are evaluated together with it. Operands have been evaluated.
    void write(int node);

private:
    int commutative(Binary op, const ProgramNode& n);
    int subtract(const ProgramNode& n);
    int negate(const ProgramNode& n);
    int square_root(const ProgramNode& n);
    int fused(Fused op, const ProgramNode& n);
    int fused_as_two(Fused op, const ProgramNode& n);
    int reciprocal(const ProgramNode& n);
    int refined_recip(int x);
    int refined_rsqrt(int x);
    int extremum(Binary op, const ProgramNode& n);
    int gate(bool passes_positive, const ProgramNode& n);
    int at_least(const ProgramNode& n);
    void call(const Call& function_call);
    /// Stores a value at a place on the stack.
    void copy_to_stack(int node, int slot);
    /// Returns the register of the result, which may be that of an operand that is not used later.
    int result_register(const ProgramNode& n);

    x86::Assembler& a_;
    VectorAssembler& v_;
    RegisterFile& r_;
    const UnrolledProgram& program_;
    int first_argument_ = -1;  ///< Place on the stack of the operands of calls; −1: not yet reserved.
};

}  // namespace kagero::compiler

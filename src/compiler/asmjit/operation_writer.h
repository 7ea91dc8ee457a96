/// Machine code of single operations.
#pragma once

#include "compiler/asmjit/register_file.h"

namespace kagero::compiler {

/// Writes the code of the nodes of one function, one after the other. The roundings and the results for 0, ∞ and NaN
/// are those of the interpreter. Operations that have no code here are calls of the functions of the value type, so
/// that a new row of the operation table needs no change.
class OperationWriter {
public:
    OperationWriter(x86::Assembler& assembler, VectorAssembler& vectors, RegisterFile& registers, const ValueType& type)
        : a_(assembler), v_(vectors), r_(registers), type_(type) {}

    /// Writes the code of a node, whose operands have been evaluated. Its value is then in a register.
    void write(int node, const ProgramNode& n);

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
    int call(const ProgramNode& n);
    /// Returns the register of the result, which may be that of an operand that is not used later.
    int result_register(const ProgramNode& n);

    x86::Assembler& a_;
    VectorAssembler& v_;
    RegisterFile& r_;
    const ValueType& type_;
};

}  // namespace kagero::compiler

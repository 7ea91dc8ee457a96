/// The interface between kernel modules and the compiler module (src/compiler), which translates the programs of a
/// scene's formula to machine code. It consists of plain structs. The compiler receives checked nodes, never text.
#pragma once

#include "kernels/abi.h"
#include "kernels/operation.h"

#include <cstdint>

namespace kagero {

/// Version of this interface. It changes with every change of the types in this file.
inline constexpr std::uint32_t code_generation_abi = 1;

enum class InstructionSet : std::uint8_t { sse2, avx2, avx512 };

/// A function of a kernel module that computes an operation for one register. Its type is R(R, R, R), where R is the
/// register type of the instruction set, or the number type if a value has one lane. Operands that the operation does
/// not use are ignored.
using OperationFunction = void (*)();

/// A type of values: `registers` registers with `lanes` numbers each. A register with one lane is a plain number.
struct ValueType {
    InstructionSet isa;
    Precision precision;
    std::uint32_t lanes, registers;
    /// The functions of the operations, indexed by `Op`; nullptr for leaves and abbreviations.
    const OperationFunction* operations;
};

/// A node of a program. Operands are indices of earlier nodes; −1: absent. In an input, `a` is its index.
struct ProgramNode {
    Op op;
    std::int32_t a, b, c;
    double value;  ///< Value of a constant.
};

/// A program for which code is generated. Nodes that no output needs are not evaluated.
struct FunctionDescription {
    const ValueType* type;
    const ProgramNode* nodes;
    std::uint32_t node_count, input_count;
    const std::int32_t* outputs;  ///< Indices of nodes.
    std::uint32_t output_count;
};

}  // namespace kagero

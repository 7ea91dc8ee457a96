/// The interface between kernel modules and the compiler module (src/compiler), which translates the programs of a
/// scene's formula to machine code. It consists of plain structs. The compiler receives checked nodes, never text.
#pragma once

#include "kernels/abi.h"
#include "kernels/operation.h"

#include <cstdint>

namespace kagero {

/// Version of this interface. It changes with every change of the types in this file.
inline constexpr std::uint32_t code_generation_abi = 2;

enum class InstructionSet : std::uint8_t { sse2, avx2, avx512 };

/// A function of a kernel module that computes an operation of the values at a, b and c. It writes the value of the
/// operation to `result`. A joint operation also writes the value of its second operation to `second_result`. Pointers
/// to operands and results that the operation does not have are ignored.
using OperationFunction = void (*)(const void* a, const void* b, const void* c, void* result, void* second_result);

/// Two operations of the same operands whose values one function computes faster than two.
struct JointOperation {
    Op first, second;
    OperationFunction function;
};

/// A type of values: `registers` registers with `lanes` numbers each. A value with one lane is a plain number.
struct ValueType {
    InstructionSet isa;
    Precision precision;
    std::uint32_t lanes, registers;
    /// The functions of the operations, indexed by `Op`; nullptr for leaves and abbreviations.
    const OperationFunction* operations;
    const JointOperation* joint_operations;
    std::uint32_t joint_operation_count;
};

/// A node of a program. Operands are indices of earlier nodes; −1: absent. In an input, `a` is its index. In a
/// constant, `a` is the only lane that has the value, while all other lanes are 0; −1: all lanes have the value.
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
    /// True: each input is one number, which all lanes have, instead of a value.
    bool inputs_are_numbers = false;
};

}  // namespace kagero

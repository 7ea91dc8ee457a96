/// The order in which the nodes of a program are evaluated.
#pragma once

#include "kernels/code_generation.h"

#include <vector>

namespace kagero::compiler {

/// Returns true for constants, parameters and inputs.
constexpr bool is_leaf(Op op) { return op <= Op::input; }

/// A program that evaluates all registers of a value together: the nodes of the first register, then those of the
/// second, and so on. Register r of input k is input k·registers + r; the same holds for outputs.
struct UnrolledProgram {
    explicit UnrolledProgram(const FunctionDescription& function);

    std::vector<ProgramNode> nodes;
    std::vector<int> outputs;

    const ProgramNode& operator[](int node) const { return nodes[std::size_t(node)]; }
};

/// Returns the nodes that the outputs need, without leaves, in an order of evaluation. The CPU executes independent
/// operations at the same time, so the nodes with the longest chains of dependent operations come first. While
/// `register_count` values are in use, nodes come first that end the use of others.
std::vector<int> evaluation_order(const UnrolledProgram& program, int register_count);

/// For each node, the positions of its uses in an order, ascending.
std::vector<std::vector<int>> uses_in_order(const UnrolledProgram& program, const std::vector<int>& order);

}  // namespace kagero::compiler

/// The order in which the nodes of a program are evaluated.
#pragma once

#include "compiler/asmjit/unrolled_program.h"

#include <vector>

namespace kagero::compiler {

/// Returns the needed nodes, without leaves, in an order of evaluation. Nodes that are evaluated together are listed by
/// their representative. The CPU executes independent operations at the same time, so the nodes with the longest chains
/// of dependent operations come first. While `register_count` values are in use, nodes come first that end the use of
/// others.
std::vector<int> evaluation_order(const UnrolledProgram& program, int register_count);

/// For each node, the positions of its uses in an order, ascending.
std::vector<std::vector<int>> uses_in_order(const UnrolledProgram& program, const std::vector<int>& order);

}  // namespace kagero::compiler

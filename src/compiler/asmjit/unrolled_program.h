/// A program in the form in which code is generated for it.
#pragma once

#include "kernels/code_generation.h"

#include <vector>

namespace kagero::compiler {

/// Returns true if the operation is a call of a function of the kernel module. All operations without code in
/// operation_writer.cpp are calls, so that a new row of the operation table needs no change.
bool is_call(Op op);

/// A call: one operation for all registers of a value, or two joint operations.
struct Call {
    OperationFunction function;
    /// The nodes of the operations: one per register, or only one if it has the same value in all registers. `second`
    /// is empty if there is one operation.
    std::vector<int> first, second;
};

/// A program that evaluates all registers of a value together: the nodes of the first register, then those of the
/// second, and so on. Nodes that have the same value in all registers are evaluated only in the first. Register r of
/// input k is input k·registers + r, unless inputs are numbers; the same holds for outputs. Calls evaluate all
/// registers of a node at once.
class UnrolledProgram {
public:
    /// ProgramNode::a of a constant that is 0 in this register, because its lane is in another one.
    static constexpr int other_register = -2;

    explicit UnrolledProgram(const FunctionDescription& function);

    int size() const { return int(nodes_.size()); }
    const ProgramNode& operator[](int node) const { return nodes_[std::size_t(node)]; }
    const std::vector<int>& outputs() const { return outputs_; }
    /// True if each input is one number, which all lanes have.
    bool inputs_are_numbers() const { return inputs_are_numbers_; }
    /// Returns true if an output depends on the node.
    bool is_needed(int node) const { return needed_[std::size_t(node)]; }
    /// Returns the call that evaluates a node; nullptr if the node has code of its own.
    const Call* call(int node) const {
        const int index = call_of_[std::size_t(node)];
        return index < 0 ? nullptr : &calls_[std::size_t(index)];
    }
    /// Returns the node that represents all nodes that are evaluated together with a node.
    int representative(int node) const { return call(node) ? call(node)->first[0] : node; }
    /// Returns the nodes that are evaluated together with a node that is a representative, and their operands.
    std::vector<int> evaluated_with(int node) const;
    std::vector<int> operands(int node) const;

private:
    void unroll(const FunctionDescription& function);
    void find_uniform_nodes(const FunctionDescription& function);
    bool is_uniform(int node) const { return uniform_[std::size_t(node)]; }
    void find_needed_nodes();
    void collect_calls(const FunctionDescription& function);

    bool inputs_are_numbers_;
    std::vector<ProgramNode> nodes_;
    std::vector<int> outputs_;
    std::vector<bool> uniform_;  ///< Per node of the first register: has the same value in all registers.
    std::vector<bool> needed_;
    std::vector<int> call_of_;  ///< Per node: index of its call; −1: none.
    std::vector<Call> calls_;
};

}  // namespace kagero::compiler

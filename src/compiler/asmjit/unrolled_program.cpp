#include "compiler/asmjit/unrolled_program.h"

#include <algorithm>
#include <iterator>

namespace kagero::compiler {
namespace {

/// Returns the lane, in register r, of a constant that is 0 in all lanes except `lane`; other_register if it is another
/// register. A negative number is returned unchanged.
int lane_in_register(int lane, int r, int lanes) {
    if (lane < 0) return lane;
    return lane / lanes == r ? lane % lanes : UnrolledProgram::other_register;
}

}  // namespace

bool is_call(Op op) {
    switch (op) {
        case Op::constant:
        case Op::parameter:
        case Op::input:
        case Op::add:
        case Op::sub:
        case Op::mul:
        case Op::neg:
        case Op::fma:
        case Op::fms:
        case Op::fnma:
        case Op::sqrt:
        case Op::recip:
        case Op::rsqrt:
        case Op::min:
        case Op::max:
        case Op::if_positive:
        case Op::unless_positive:
        case Op::at_least: return false;
        default: return true;
    }
}

UnrolledProgram::UnrolledProgram(const FunctionDescription& function)
    : inputs_are_numbers_(function.inputs_are_numbers) {
    unroll(function);
    find_needed_nodes();
    collect_calls(function);
}

void UnrolledProgram::unroll(const FunctionDescription& function) {
    const auto registers = int(function.type->registers), count = int(function.node_count);
    find_uniform_nodes(function);
    const auto moved = [&](int operand, int r) {
        return operand < 0 || is_uniform(operand) ? operand : operand + r * count;
    };
    for (int r = 0; r < registers; ++r)
        for (int k = 0; k < count; ++k) {
            const ProgramNode& n = function.nodes[k];
            if (n.op == Op::input)
                nodes_.push_back({n.op, function.inputs_are_numbers ? n.a : n.a * registers + r, -1, -1, 0});
            else if (n.op == Op::constant)
                nodes_.push_back({n.op, lane_in_register(n.a, r, int(function.type->lanes)), -1, -1, n.value});
            else nodes_.push_back({n.op, moved(n.a, r), moved(n.b, r), moved(n.c, r), n.value});
        }
    for (std::uint32_t o = 0; o < function.output_count; ++o)
        for (int r = 0; r < registers; ++r) outputs_.push_back(moved(function.outputs[o], r));
}

void UnrolledProgram::find_uniform_nodes(const FunctionDescription& function) {
    for (std::uint32_t k = 0; k < function.node_count; ++k) {
        const ProgramNode& n = function.nodes[k];
        bool uniform = true;
        if (n.op == Op::constant) uniform = n.a < 0;
        else if (n.op == Op::input) uniform = function.inputs_are_numbers;
        else
            for (const int operand : {n.a, n.b, n.c}) uniform = uniform && (operand < 0 || is_uniform(operand));
        uniform_.push_back(uniform);
    }
}

void UnrolledProgram::find_needed_nodes() {
    needed_.resize(nodes_.size());
    for (const int output : outputs_) needed_[std::size_t(output)] = true;
    for (int k = size() - 1; k >= 0; --k) {
        const ProgramNode& n = nodes_[std::size_t(k)];
        if (!is_needed(k) || is_leaf(n.op)) continue;
        for (const int operand : {n.a, n.b, n.c})
            if (operand >= 0) needed_[std::size_t(operand)] = true;
    }
}

void UnrolledProgram::collect_calls(const FunctionDescription& function) {
    call_of_.assign(nodes_.size(), -1);
    const ValueType& type = *function.type;
    const auto count = int(function.node_count);
    const auto nodes_in_all_registers = [&](int k, std::vector<int>& list) {
        for (int r = 0; r < (is_uniform(k) ? 1 : int(type.registers)); ++r) {
            list.push_back(k + r * count);
            call_of_[std::size_t(k + r * count)] = int(calls_.size());
        }
    };
    for (int k = 0; k < count; ++k) {
        const ProgramNode& n = function.nodes[k];
        if (!is_needed(k) || call(k) || !is_call(n.op)) continue;
        Call call{type.operations[int(n.op)], {}, {}};
        nodes_in_all_registers(k, call.first);
        // Returns the index of a later node with the same operands and the operation `op`; `count` if there is none.
        const auto find_other = [&](Op op) {
            int other = k + 1;
            for (; other < count; ++other) {
                const ProgramNode& m = function.nodes[other];
                if (is_needed(other) && m.op == op && m.a == n.a && m.b == n.b && m.c == n.c) break;
            }
            return other;
        };
        for (std::uint32_t j = 0; j < type.joint_operation_count && call.second.empty(); ++j) {
            const JointOperation& joint = type.joint_operations[j];
            if (n.op != joint.first && n.op != joint.second) continue;
            const int other = find_other(n.op == joint.first ? joint.second : joint.first);
            if (other == count) continue;
            call.function = joint.function;
            nodes_in_all_registers(other, call.second);
            if (n.op == joint.second) std::swap(call.first, call.second);
        }
        calls_.push_back(std::move(call));
    }
}

std::vector<int> UnrolledProgram::evaluated_with(int node) const {
    const Call* const its_call = call(node);
    if (!its_call) return {node};
    std::vector<int> all = its_call->first;
    all.insert(all.end(), its_call->second.begin(), its_call->second.end());
    return all;
}

std::vector<int> UnrolledProgram::operands(int node) const {
    std::vector<int> list;
    for (const int member : call(node) ? call(node)->first : std::vector<int>{node}) {
        const ProgramNode& n = (*this)[member];
        for (const int operand : {n.a, n.b, n.c})
            if (operand >= 0 && std::find(list.begin(), list.end(), operand) == list.end()) list.push_back(operand);
    }
    return list;
}

}  // namespace kagero::compiler

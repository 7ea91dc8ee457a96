#include "compiler/asmjit/register_file.h"

#include <algorithm>
#include <limits>

namespace kagero::compiler {

RegisterFile::RegisterFile(VectorAssembler& assembler, const UnrolledProgram& program,
                           const std::vector<std::vector<int>>& uses, const x86::Gp& inputs)
    : assembler_(assembler), program_(program), uses_(uses), inputs_(inputs),
      register_of_(std::size_t(program.size()), -1), slot_of_(std::size_t(program.size()), -1),
      node_in_(std::size_t(assembler.register_count()), -1), pinned_(std::size_t(assembler.register_count())) {}

void RegisterFile::begin(int position, int node) {
    position_ = position;
    std::fill(pinned_.begin(), pinned_.end(), false);
    for (const int operand : program_.operands(node))
        if (is_in_register(operand)) pinned_[std::size_t(register_of_[std::size_t(operand)])] = true;
}

int RegisterFile::next_use(int node) const {
    const std::vector<int>& list = uses_[std::size_t(node)];
    const auto next = std::upper_bound(list.begin(), list.end(), position_);
    return next == list.end() ? std::numeric_limits<int>::max() : *next;
}

bool RegisterFile::is_used_later(int node) const {
    const std::vector<int>& list = uses_[std::size_t(node)];
    return !list.empty() && list.back() > position_;
}

bool RegisterFile::has_memory(int node) const { return is_leaf(program_[node].op) || slot_of_[std::size_t(node)] >= 0; }

x86::Mem RegisterFile::memory(int node) {
    const ProgramNode& n = program_[node];
    if (n.op == Op::constant && n.a >= 0) return assembler_.lane_constant(n.value, n.a);
    if (n.op == Op::constant) return assembler_.constant(n.a == UnrolledProgram::other_register ? 0 : n.value);
    if (n.op == Op::input && program_.inputs_are_numbers())
        return x86::ptr(inputs_, n.a * assembler_.number_size(), std::uint32_t(assembler_.number_size()));
    if (n.op == Op::input)
        return x86::ptr(inputs_, n.a * assembler_.value_size(), std::uint32_t(assembler_.value_size()));
    return stack_slot(slot_of_[std::size_t(node)]);
}

void RegisterFile::load(int reg, int node) {
    const ProgramNode& n = program_[node];
    if (is_in_register(node)) assembler_.move(reg, register_of_[std::size_t(node)]);
    else if (n.op == Op::constant && n.a == -1) assembler_.load_constant(reg, n.value);
    else if (n.op == Op::constant && n.a < 0) assembler_.load_constant(reg, 0);
    else if (n.op == Op::constant) assembler_.load_register(reg, memory(node));
    else if (n.op == Op::input && program_.inputs_are_numbers()) assembler_.load_number(reg, memory(node));
    else if (n.op == Op::input) assembler_.load_value(reg, memory(node));
    else assembler_.load_register(reg, memory(node));
}

int RegisterFile::in_register(int node) {
    if (!is_in_register(node)) {
        const int reg = take();
        load(reg, node);
        define(node, reg);
    }
    const int reg = register_of_[std::size_t(node)];
    pinned_[std::size_t(reg)] = true;
    return reg;
}

bool RegisterFile::reads_from_memory(int node) const {
    if (is_in_register(node)) return false;
    if (program_[node].op == Op::constant) return true;
    if (program_[node].op == Op::input && (program_.inputs_are_numbers() || !assembler_.reads_values_from_memory()))
        return false;
    return !is_used_later(node);
}

asmjit::Operand RegisterFile::source(int node) {
    if (reads_from_memory(node)) return memory(node);
    return assembler_.reg(in_register(node));
}

int RegisterFile::take() {
    int best = -1, best_use = -1;
    for (int r = 0; r < int(node_in_.size()); ++r) {
        if (pinned_[std::size_t(r)]) continue;
        const int node = node_in_[std::size_t(r)];
        // A free register is best, and then the one whose value is used last.
        const int use = node < 0 ? std::numeric_limits<int>::max() : next_use(node);
        if (best < 0 || use > best_use) {
            best = r;
            best_use = use;
        }
        if (node < 0) break;
    }
    if (const int node = node_in_[std::size_t(best)]; node >= 0) {
        if (is_used_later(node)) store(node);
        register_of_[std::size_t(node)] = -1;
        node_in_[std::size_t(best)] = -1;
    }
    pinned_[std::size_t(best)] = true;
    return best;
}

void RegisterFile::store(int node) {
    if (has_memory(node)) return;
    slot_of_[std::size_t(node)] = reserve_slots(1);
    assembler_.store_register(memory(node), register_of_[std::size_t(node)]);
}

void RegisterFile::release_operands(const ProgramNode& node) {
    for (const int operand : {node.a, node.b, node.c}) {
        if (operand < 0 || !is_last_use_in_register(operand)) continue;
        const auto reg = std::size_t(register_of_[std::size_t(operand)]);
        node_in_[reg] = -1;
        pinned_[reg] = false;
        register_of_[std::size_t(operand)] = -1;
    }
}

void RegisterFile::define(int node, int reg) {
    node_in_[std::size_t(reg)] = node;
    register_of_[std::size_t(node)] = reg;
}

void RegisterFile::store_all() {
    for (const int node : node_in_)
        if (node >= 0 && is_used_later(node)) store(node);
}

x86::Mem RegisterFile::define_in_memory(const std::vector<int>& nodes) {
    const int first = reserve_slots(assembler_.registers());
    for (std::size_t i = 0; i < nodes.size(); ++i) slot_of_[std::size_t(nodes[i])] = first + int(i);
    return stack_slot(first);
}

x86::Mem RegisterFile::stack_slot(int index) const {
    const int size = assembler_.register_size();
    return x86::ptr(x86::rsp, index * size, std::uint32_t(size));
}

int RegisterFile::reserve_slots(int count) {
    const int first = slot_count_;
    slot_count_ += count;
    return first;
}

void RegisterFile::forget_registers() {
    for (int& node : node_in_) {
        if (node >= 0) register_of_[std::size_t(node)] = -1;
        node = -1;
    }
    std::fill(pinned_.begin(), pinned_.end(), false);
}

}  // namespace kagero::compiler

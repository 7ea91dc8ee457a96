/// Register allocation for straight-line code: the values of nodes in registers, on the stack, or in their original
/// place in memory.
#pragma once

#include "compiler/asmjit/unrolled_program.h"
#include "compiler/asmjit/vector_assembler.h"

#include <vector>

namespace kagero::compiler {

/// The values of the nodes of one function. If no register is free, the register whose value is used last is taken
/// (Belady 1966). Inputs and constants are then read from memory again; other values are stored on the stack once.
class RegisterFile {
public:
    /// `uses` are the positions at which each node is used.
    RegisterFile(VectorAssembler& assembler, const UnrolledProgram& program, const std::vector<std::vector<int>>& uses,
                 const x86::Gp& inputs);

    /// Number of bytes of the stack that stored values occupy.
    int stack_size() const { return slot_count_ * assembler_.register_size(); }

    /// Begins the instructions of the node at a position. Its operands that are in registers stay there.
    void begin(int position, int node);
    /// Returns the register of a node's value, which is loaded if necessary.
    int in_register(int node);
    /// Returns true if the value is in a register.
    bool is_in_register(int node) const { return register_of_[std::size_t(node)] >= 0; }
    /// Returns true if an instruction at this position should read the value from memory: it is not in a register, and
    /// it is not used later, or it is a constant.
    bool reads_from_memory(int node) const;
    /// Returns a source for an instruction: the value's place in memory if `reads_from_memory`, else a register.
    asmjit::Operand source(int node);
    /// Returns true if the value is in a register and not used after this position.
    bool is_last_use_in_register(int node) const { return is_in_register(node) && !is_used_later(node); }
    /// Returns a free register, which is not taken again at this position.
    int take();
    /// Releases the registers of the operands that are not used after this position.
    void release_operands(const ProgramNode& node);
    /// Makes a register the place of a node's value. It is released if the value is never used.
    void define(int node, int reg);
    /// Loads a copy of the value into a register.
    void load(int reg, int node);
    /// Stores all values that are used after this position, before a call.
    void store_all();
    /// Empties all registers, after a call.
    void forget_registers();
    /// Reserves places on the stack for all registers of a value, and makes them the places of the nodes' values.
    /// Returns the first.
    x86::Mem define_in_memory(const std::vector<int>& nodes);
    /// Returns the place of a value with an index on the stack.
    x86::Mem stack_slot(int index) const;
    /// Reserves consecutive places on the stack and returns the index of the first.
    int reserve_slots(int count);

private:
    bool is_used_later(int node) const;
    int next_use(int node) const;
    /// The place in memory of a value that is not only in a register.
    x86::Mem memory(int node);
    bool has_memory(int node) const;
    void store(int node);
    VectorAssembler& assembler_;
    const UnrolledProgram& program_;
    const std::vector<std::vector<int>>& uses_;
    x86::Gp inputs_;
    std::vector<int> register_of_, slot_of_;  ///< Per node; −1: none.
    std::vector<int> node_in_;                ///< Per register; −1: none.
    std::vector<bool> pinned_;                ///< Per register: used by the instructions at this position.
    int position_ = 0, slot_count_ = 0;
};

}  // namespace kagero::compiler

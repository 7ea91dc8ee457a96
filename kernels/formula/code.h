/// Code: the programs of a formula as data. The compiler module translates code to machine code; without this module,
/// an interpreter executes it.
///
/// Instructions operate on numbered slots, which contain the inputs, the constants and then the results. Instructions
/// are grouped into runs of the same operation on independent operands. An operation is then dispatched once per run,
/// and the CPU can overlap the instructions of the run. If fewer than three instructions can form a run, an operation
/// on the accumulator is preferred. The accumulator is the result of the previous instruction, which is still in a
/// register.
#pragma once

#include "kernels/equations/system.h"
#include "kernels/formula/compiled.h"

#include <algorithm>
#include <cstdint>

namespace kagero::formula {

/// One instruction. Operands and the result are offsets: slot number times `offset_unit`. The addressing modes of the
/// CPU scale them to the size of a packet without extra instructions.
struct Instruction {
    static constexpr std::size_t offset_unit = 16;
    std::uint16_t result, a, b, c;
};
static_assert(256 * Instruction::offset_unit <= 1 << 16);

/// Operations on the accumulator L. The opcode of a run is an `Op` or one of these.
enum class AccumulatorOp : std::uint8_t {
    add = op_count,  ///< L + b
    mul,             ///< L·b
    rsqrt,           ///< 1/√L
    recip,           ///< 1/L
    fma,             ///< L·b + c
    add_product,     ///< a·b + L
    fnma,            ///< c − L·b
    minus_product,   ///< L − a·b
};
constexpr std::uint8_t opcode_of(Op op) { return static_cast<std::uint8_t>(op); }
constexpr std::uint8_t opcode_of(AccumulatorOp op) { return static_cast<std::uint8_t>(op); }

/// A run: instructions [first, first + count) with the same opcode. A run on the accumulator stores only the result of
/// its last instruction. `stores_result` is false if only the next run uses the result, from the accumulator.
struct Run {
    std::uint8_t opcode;
    bool stores_result;
    std::uint16_t first, count;
};

/// The outputs of the program of event functions of a formula: those of EventFunctionIndex, then Ω.
enum { index_time_rescaling = event_function_count, formula_function_count };

/// A program in the form that the interpreter executes.
struct Code {
    static constexpr int max_inputs = state_size + static_cast<int>(max_formula_parameters);
    static constexpr int max_slots = 256, max_outputs = formula_function_count;
    std::int32_t inputs = state_size;  ///< number of inputs: the state, then parameters of the formula
    std::int32_t slots, constants, runs, outputs;  ///< numbers of used slots, constants, runs and outputs
    /// Number of runs at the beginning of the code that do not depend on the varying inputs (the constructor argument
    /// of CodeWriter).
    std::int32_t prepared_runs;
    Run run[Tape::capacity];
    Instruction instruction[Tape::capacity];
    double constant[max_slots];  ///< the constants; their slots begin at `inputs`
    std::uint16_t output[max_outputs];  ///< slots of the outputs
    CompiledProgram compiled[compiled_type_count];  ///< the same program as machine code, per value type

    /// Returns the machine code for a value type, or nullptr if there is none.
    template <class V>
    const CompiledProgram* compiled_for() const {
        if constexpr (compiled_type<V> < 0) return nullptr;
        else return compiled[compiled_type<V>].evaluate ? &compiled[compiled_type<V>] : nullptr;
    }
};

/// Converts a program to code: puts the operations in order and assigns slots to the results. Operations that do not
/// depend on the varying inputs come first. Parameters are inputs that do not vary.
template <int Size, int Outputs>
class CodeWriter {
public:
    CodeWriter(const Program<Size, Outputs>& program, VaryingInputs varying, Code& code) : p_(program), code_(code) {
        for (int k = 0; k < p_.size; ++k) {
            const Node& n = p_.nodes[k];
            if (n.op == Op::input) varies_[k] = n.a >= varying.first && n.a < varying.last;
            else if (!is_leaf(n.op))
                for (const int operand : {n.a, n.b, n.c})
                    if (operand >= 0) {
                        varies_[k] = varies_[k] || varies_[operand];
                        ++uses_[operand];
                    }
        }
        for (const int o : p_.outputs) ++uses_[o];
    }

    /// Writes the code. Returns false if the program needs more slots than exist.
    bool write() {
        code_.runs = code_.constants = code_.prepared_runs = 0;
        if (!p_.complete) return false;
        schedule(false);
        code_.prepared_runs = code_.runs;
        first_varying_ = length_;
        schedule(true);
        find_last_uses();
        return assign_leaf_slots() && assign_result_slots();
    }

private:
    /// Returns true if node k is absent (k < 0), is a leaf, or is already scheduled.
    bool available(int k) const { return k < 0 || is_leaf(p_.nodes[k].op) || scheduled_[k]; }
    /// Returns true if node k can be scheduled next: its operands are available, and it depends on the varying inputs
    /// if and only if `varying` is true.
    bool ready(int k, bool varying) const {
        const Node& n = p_.nodes[k];
        return !is_leaf(n.op) && !scheduled_[k] && varies_[k] == varying && available(n.a) && available(n.b) &&
               available(n.c);
    }
    /// Schedules the nodes that depend on the varying inputs if `varying` is true, else the other nodes. Each run
    /// contains all ready nodes of the operation with the most ready nodes. If these are fewer than three, an operation
    /// on the accumulator is scheduled first, if possible.
    void schedule(bool varying) {
        accumulator_ = -1;
        for (;;) {
            int counts[op_count] = {}, best = 0;
            for (int k = 0; k < p_.size; ++k)
                if (ready(k, varying)) ++counts[static_cast<int>(p_.nodes[k].op)];
            for (int i = 1; i < op_count; ++i)
                if (counts[i] > counts[best]) best = i;
            if (counts[best] == 0) return;
            if (counts[best] < 3 && schedule_on_accumulator(varying)) continue;
            const int first = length_;
            for (int k = 0; k < p_.size; ++k)
                if (ready(k, varying) && static_cast<int>(p_.nodes[k].op) == best) order_[length_++] = k;
            for (int i = first; i < length_; ++i) scheduled_[order_[i]] = true;
            accumulator_ = order_[length_ - 1];
            code_.run[code_.runs++] = {static_cast<std::uint8_t>(best), true, static_cast<std::uint16_t>(first),
                                       static_cast<std::uint16_t>(length_ - first)};
        }
    }
    /// Schedules one operation on the accumulator. Returns false if no ready node is such an operation.
    bool schedule_on_accumulator(bool varying) {
        for (int k = 0; accumulator_ >= 0 && k < p_.size; ++k) {
            if (!ready(k, varying)) continue;
            const std::uint8_t opcode = accumulator_opcode(p_.nodes[k]);
            if (opcode == 0) continue;
            operands_swapped_[length_] = p_.nodes[k].b == accumulator_;
            append_to_run(opcode, uses_[accumulator_] == 1);
            order_[length_++] = accumulator_ = k;
            scheduled_[k] = true;
            return true;
        }
        return false;
    }
    /// Appends an instruction on the accumulator to the last run, or to a new run. `no_other_use` is true if no other
    /// instruction uses the accumulator's value.
    void append_to_run(std::uint8_t opcode, bool no_other_use) {
        Run& before = code_.run[code_.runs - 1];
        if (no_other_use && before.opcode == opcode) {
            ++before.count;
            return;
        }
        if (no_other_use && (before.count == 1 || before.opcode >= opcode_of(AccumulatorOp::add)))
            before.stores_result = false;
        code_.run[code_.runs++] = {opcode, true, static_cast<std::uint16_t>(length_), 1};
    }
    /// Returns the opcode of node n as an operation on the accumulator; 0 if there is no such operation, or if n does
    /// not use the accumulator exactly once.
    std::uint8_t accumulator_opcode(const Node& n) const {
        const bool a = n.a == accumulator_, b = n.b == accumulator_, c = n.c == accumulator_;
        if (a + b + c != 1) return 0;
        switch (n.op) {
            case Op::add: return opcode_of(AccumulatorOp::add);
            case Op::mul: return opcode_of(AccumulatorOp::mul);
            case Op::rsqrt: return opcode_of(AccumulatorOp::rsqrt);
            case Op::recip: return opcode_of(AccumulatorOp::recip);
            case Op::fma: return opcode_of(c ? AccumulatorOp::add_product : AccumulatorOp::fma);
            case Op::fnma: return opcode_of(c ? AccumulatorOp::minus_product : AccumulatorOp::fnma);
            default: return 0;
        }
    }
    /// Finds the last instruction that uses each result. Outputs stay in use until the end of the code. So do results
    /// that do not depend on the varying inputs but are operands of operations that do, because the latter operations
    /// may be executed several times.
    void find_last_uses() {
        for (int i = 0; i < length_; ++i) {
            const Node& n = p_.nodes[order_[i]];
            for (const int operand : {n.a, n.b, n.c})
                if (operand >= 0) last_use_[operand] = i >= first_varying_ && !varies_[operand] ? length_ : i;
        }
        for (const int o : p_.outputs) last_use_[o] = length_;
    }
    /// Assigns slots to the inputs and constants. Returns false if there are too few slots.
    bool assign_leaf_slots() {
        code_.inputs = state_size;
        for (int k = 0; k < p_.size; ++k) {
            const Node& n = p_.nodes[k];
            if (n.op == Op::input) slot_[k] = n.a;
            if (n.op != Op::parameter) continue;
            slot_[k] = state_size + n.a;
            code_.inputs = std::max(code_.inputs, slot_[k] + 1);
        }
        for (int k = 0; k < p_.size; ++k) {
            if (p_.nodes[k].op != Op::constant) continue;
            if (code_.inputs + code_.constants == Code::max_slots) return false;
            slot_[k] = code_.inputs + code_.constants;
            code_.constant[code_.constants++] = p_.nodes[k].value;
        }
        code_.slots = code_.inputs + code_.constants;
        return true;
    }
    /// Assigns slots to results; a slot is free again after its last use. Returns false if there are too few slots.
    bool assign_result_slots() {
        int free_slots[Code::max_slots], free_count = 0;
        for (int i = 0; i < length_; ++i) {
            const int k = order_[i];
            const Node& n = p_.nodes[k];
            Instruction& to = code_.instruction[i];
            const int a = operands_swapped_[i] ? n.b : n.a, b = operands_swapped_[i] ? n.a : n.b;
            to = {0, offset_of(a), offset_of(b), offset_of(n.c)};
            const int operands[3] = {n.a, n.b != n.a ? n.b : -1, n.c != n.a && n.c != n.b ? n.c : -1};
            for (const int operand : operands)
                if (operand >= 0 && !is_leaf(p_.nodes[operand].op) && last_use_[operand] == i)
                    free_slots[free_count++] = slot_[operand];
            if (free_count == 0 && code_.slots == Code::max_slots) return false;
            slot_[k] = free_count ? free_slots[--free_count] : code_.slots++;
            to.result = offset_of(k);
        }
        static_assert(Outputs <= Code::max_outputs);
        code_.outputs = Outputs;
        for (int o = 0; o < Outputs; ++o) code_.output[o] = slot_of(p_.outputs[o]);
        return true;
    }
    std::uint16_t slot_of(int k) const { return k < 0 ? std::uint16_t(0) : static_cast<std::uint16_t>(slot_[k]); }
    std::uint16_t offset_of(int k) const { return static_cast<std::uint16_t>(slot_of(k) * Instruction::offset_unit); }

    const Program<Size, Outputs>& p_;
    Code& code_;
    bool varies_[Size] = {};            ///< per node: depends on the varying inputs
    bool scheduled_[Size] = {};         ///< per node: has an instruction
    bool operands_swapped_[Size] = {};  ///< per instruction: a and b are exchanged, because the accumulator is b
    int order_[Size] = {};              ///< per instruction: its node
    int uses_[Size] = {};               ///< per node: number of uses as an operand or output
    int last_use_[Size] = {};           ///< per node: index of the last instruction that uses the result
    int slot_[Size] = {};               ///< per node: slot of the result
    int length_ = 0;                    ///< number of instructions so far
    int first_varying_ = 0;             ///< first instruction that depends on the varying inputs
    int accumulator_ = -1;              ///< the node whose result is in the accumulator; −1: none
};

}  // namespace kagero::formula

#include "compiler/asmjit/function_writer.h"

#include "compiler/asmjit/operation_writer.h"
#include "compiler/asmjit/order.h"

#include <algorithm>

namespace kagero::compiler {
namespace {

/// Writes one function.
class FunctionWriter {
public:
    FunctionWriter(x86::Assembler& assembler, const FunctionDescription& function)
        : a_(assembler), program_(function), v_(assembler, *function.type),
          order_(evaluation_order(program_, v_.register_count() - reserve)), uses_(uses_in_order(program_, order_)),
          registers_(v_, program_, uses_, inputs), operations_(assembler, v_, registers_, program_),
          input_size_(function.inputs_are_numbers
                          ? int(function.input_count) * v_.number_size()
                          : int(function.input_count * function.type->registers) * v_.value_size()) {}

    void write() {
        begin();
        const asmjit::Label point = a_.newLabel();
        a_.bind(point);
        write_program();
        a_.add(inputs, input_size_);
        a_.add(outputs, int(program_.outputs().size()) * v_.value_size());
        a_.dec(points);
        a_.jnz(point);
        end();
        v_.write_constants();
    }

private:
    /// These registers keep their values in calls.
    static constexpr x86::Gp inputs = x86::rbx, outputs = x86::r12, points = x86::r13;
    /// Number of vector registers that the order of evaluation leaves free for inputs and temporary values.
    static constexpr int reserve = 5;

    /// Saves registers, and reserves aligned memory on the stack, whose size is known only after the program.
    void begin() {
        a_.push(x86::rbp);
        a_.mov(x86::rbp, x86::rsp);
        for (const x86::Gp& saved : {inputs, outputs, points}) a_.push(saved);
        frame_offset_ = a_.offset();
        a_.long_().sub(x86::rsp, 0x7fffffff);
        a_.and_(x86::rsp, -64);
        a_.mov(inputs, x86::rdi);
        a_.mov(outputs, x86::rsi);
        a_.mov(points, x86::rdx);
    }
    void end() {
        v_.end_wide_registers();
        a_.lea(x86::rsp, x86::ptr(x86::rbp, -3 * 8));
        for (const x86::Gp& saved : {points, outputs, inputs, x86::Gp(x86::rbp)}) a_.pop(saved);
        a_.ret();
        const std::size_t end = a_.offset();
        a_.setOffset(frame_offset_);
        a_.long_().sub(x86::rsp, std::max(64, registers_.stack_size()));
        a_.setOffset(end);
    }
    void write_program() {
        const int output_count = int(program_.outputs().size());
        for (std::size_t i = 0; i < order_.size(); ++i) {
            registers_.begin(int(i), order_[i]);
            operations_.write(order_[i]);
            for (const int node : program_.evaluated_with(order_[i]))
                for (int o = 0; o < output_count; ++o)
                    if (output(o) == node) store_output(o, registers_.in_register(node));
        }
        for (int o = 0; o < output_count; ++o) {
            if (!is_leaf(program_[output(o)].op)) continue;
            registers_.load(v_.scratch(), output(o));
            store_output(o, v_.scratch());
        }
        registers_.forget_registers();
    }
    int output(int o) const { return program_.outputs()[std::size_t(o)]; }
    void store_output(int o, int reg) { v_.store_value(x86::ptr(outputs, o * v_.value_size()), reg); }

    x86::Assembler& a_;
    const UnrolledProgram program_;
    VectorAssembler v_;
    std::vector<int> order_;
    std::vector<std::vector<int>> uses_;
    RegisterFile registers_;
    OperationWriter operations_;
    int input_size_;  ///< Size of the inputs of one point in bytes.
    std::size_t frame_offset_ = 0;
};

}  // namespace

void write_function(asmjit::x86::Assembler& assembler, const FunctionDescription& function) {
    FunctionWriter(assembler, function).write();
}

}  // namespace kagero::compiler

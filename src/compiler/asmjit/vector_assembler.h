/// Vector instructions for one value type. All instruction sets have the same functions here: instructions with three
/// operands, fused operations, and comparisons that are followed by a blend.
#pragma once

#include "kernels/code_generation.h"

#include <asmjit/x86.h>

#include <utility>
#include <vector>

namespace kagero::compiler {

namespace x86 = asmjit::x86;

/// Arithmetic with two operands. `min` and `max` return b if an operand is NaN, or if both are 0.
enum class Binary : std::uint8_t { add, sub, mul, div, min, max, xor_ };
/// The conditions a ≤ b, and "a or b is NaN".
enum class Condition : std::uint8_t { less_equal = 2, unordered = 3 };
/// Fused operations: a·b + c, a·b − c and c − a·b.
enum class Fused : std::uint8_t { add, sub, neg };

/// Emits instructions on the registers of a value type. A register is stated by its number, a source is a register or
/// a memory operand. Values with one lane are in the lowest lane of a register; the results in other lanes are ignored.
class VectorAssembler {
public:
    VectorAssembler(x86::Assembler& assembler, const ValueType& type);

    /// Number of registers that hold values. One more register is `scratch()`.
    int register_count() const { return register_count_; }
    int scratch() const { return register_count_; }
    /// Size of a register in arrays of values, and of a register that is stored completely.
    int value_size() const { return int(type_.lanes) * number_size_; }
    int register_size() const { return register_size_; }
    bool has_fused() const { return type_.isa != InstructionSet::sse2; }
    bool has_estimates() const { return type_.isa == InstructionSet::avx512; }
    bool is_double() const { return type_.precision == Precision::float64; }
    /// True if instructions can read values from memory. A value with one lane is smaller than a register.
    bool reads_values_from_memory() const { return type_.lanes > 1; }

    x86::Vec reg(int r) const;
    int registers() const { return int(type_.registers); }
    int number_size() const { return number_size_; }
    /// The memory operand of a constant.
    x86::Mem constant(double value);
    /// The memory operand of a constant that only one lane has, while the other lanes are 0.
    x86::Mem lane_constant(double value, int lane);
    /// Writes the constants after the code of a function.
    void write_constants();

    void move(int d, int from);
    void load_value(int d, const x86::Mem& from);
    void store_value(const x86::Mem& to, int from);
    void load_register(int d, const x86::Mem& from);
    void store_register(const x86::Mem& to, int from);
    void load_constant(int d, double value);
    /// Loads one number into all lanes.
    void load_number(int d, const x86::Mem& from);

    /// d = a op b. May change `scratch()` unless it is d.
    void binary(Binary op, int d, int a, const asmjit::Operand& b);
    void sqrt(int d, const asmjit::Operand& a);
    /// Replaces one operand by the result of a fused operation; the last operand may be in memory.
    void fused_into_c(Fused op, int c, int a, const asmjit::Operand& b);
    void fused_into_a(Fused op, int a, int b, const asmjit::Operand& c);
    /// Estimates of 1/a and 1/√a; only for AVX-512.
    void estimate_recip(int d, int a);
    void estimate_rsqrt(int d, int a);
    /// Compares a and b. The mask is kept until the next comparison, on SSE and AVX2 in the register `mask`.
    void compare(Condition condition, int mask, int a, int b);
    /// d = a where the mask is set, else b. d must not be `mask`; it may be a or b. Changes `scratch()`.
    void blend(int d, int mask, int a, int b);
    /// Ends the use of wide registers, before a return or call to code that may use SSE.
    void end_wide_registers();

private:
    using Id = asmjit::InstId;
    /// Emits the instruction d = a op b with its identifiers for AVX and for SSE.
    void three_operands(Id avx, Id sse, int d, int a, const asmjit::Operand& b);
    Id by_precision(Id for_double, Id for_float) const { return is_double() ? for_double : for_float; }
    bool is_sse() const { return type_.isa == InstructionSet::sse2; }

    x86::Assembler& a_;
    const ValueType& type_;
    int number_size_, register_size_, register_count_;
    asmjit::Label constants_label_;
    std::vector<double> constants_;
    asmjit::Label lane_constants_label_;
    std::vector<std::pair<double, int>> lane_constants_;  ///< Values with their lanes.
};

}  // namespace kagero::compiler

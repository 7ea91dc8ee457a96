#include "compiler/asmjit/vector_assembler.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace kagero::compiler {
namespace {

using asmjit::Operand;
namespace I = x86::Inst;

/// Returns the operand as a register number; −1 if it is in memory.
int number_of(const Operand& operand) { return operand.isReg() ? int(operand.as<x86::Vec>().id()) : -1; }

/// Returns true if two numbers have the same bits. Unlike ==, this distinguishes 0 from −0, and a NaN equals itself.
bool same_bits(double a, double b) { return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b); }

/// Identifiers of an instruction: for double and float, with the encodings of AVX and SSE.
struct Ids {
    asmjit::InstId avx_double, avx_float, sse_double, sse_float;
};
constexpr Ids binary_ids[] = {
    {I::kIdVaddpd, I::kIdVaddps, I::kIdAddpd, I::kIdAddps}, {I::kIdVsubpd, I::kIdVsubps, I::kIdSubpd, I::kIdSubps},
    {I::kIdVmulpd, I::kIdVmulps, I::kIdMulpd, I::kIdMulps}, {I::kIdVdivpd, I::kIdVdivps, I::kIdDivpd, I::kIdDivps},
    {I::kIdVminpd, I::kIdVminps, I::kIdMinpd, I::kIdMinps}, {I::kIdVmaxpd, I::kIdVmaxps, I::kIdMaxpd, I::kIdMaxps},
    {I::kIdVxorpd, I::kIdVxorps, I::kIdXorpd, I::kIdXorps},
};
/// Identifiers of the fused instructions that replace the addend c (231) or the factor a (213).
struct FusedIds {
    asmjit::InstId into_c_double, into_c_float, into_a_double, into_a_float;
};
constexpr FusedIds fused_ids[] = {
    {I::kIdVfmadd231pd, I::kIdVfmadd231ps, I::kIdVfmadd213pd, I::kIdVfmadd213ps},
    {I::kIdVfmsub231pd, I::kIdVfmsub231ps, I::kIdVfmsub213pd, I::kIdVfmsub213ps},
    {I::kIdVfnmadd231pd, I::kIdVfnmadd231ps, I::kIdVfnmadd213pd, I::kIdVfnmadd213ps},
};

}  // namespace

VectorAssembler::VectorAssembler(x86::Assembler& assembler, const ValueType& type)
    : a_(assembler), type_(type), number_size_(is_double() ? sizeof(double) : sizeof(float)),
      register_size_(std::max(16, value_size())), register_count_((type.isa == InstructionSet::avx512 ? 32 : 16) - 1),
      constants_label_(assembler.newLabel()), lane_constants_label_(assembler.newLabel()) {}

x86::Vec VectorAssembler::reg(int r) const {
    const auto id = std::uint32_t(r);
    if (register_size_ == 64) return x86::zmm(id);
    if (register_size_ == 32) return x86::ymm(id);
    return x86::xmm(id);
}

x86::Mem VectorAssembler::constant(double value) {
    const auto found =
        std::find_if(constants_.begin(), constants_.end(), [&](double other) { return same_bits(other, value); });
    const auto index = int(found - constants_.begin());
    if (found == constants_.end()) constants_.push_back(value);
    if (type_.isa != InstructionSet::avx512)
        return x86::ptr(constants_label_, index * register_size_, std::uint32_t(register_size_));
    // AVX-512 instructions read one number and copy it to all lanes.
    x86::Mem number = x86::ptr(constants_label_, index * number_size_, std::uint32_t(number_size_));
    const int lanes = register_size_ / number_size_;
    number.setBroadcast(lanes == 16  ? x86::Mem::Broadcast::k1To16
                        : lanes == 8 ? x86::Mem::Broadcast::k1To8
                        : lanes == 4 ? x86::Mem::Broadcast::k1To4
                                     : x86::Mem::Broadcast::k1To2);
    return number;
}

x86::Mem VectorAssembler::lane_constant(double value, int lane) {
    const auto found = std::find_if(lane_constants_.begin(), lane_constants_.end(), [&](const auto& other) {
        return same_bits(other.first, value) && other.second == lane;
    });
    const auto index = int(found - lane_constants_.begin());
    if (found == lane_constants_.end()) lane_constants_.push_back({value, lane});
    return x86::ptr(lane_constants_label_, index * register_size_, std::uint32_t(register_size_));
}

void VectorAssembler::write_constants() {
    const int lanes = register_size_ / number_size_;
    const auto embed = [this](double value) {
        const auto number = float(value);
        if (is_double()) a_.embed(&value, sizeof value);
        else a_.embed(&number, sizeof number);
    };
    a_.align(asmjit::AlignMode::kData, 64);
    a_.bind(constants_label_);
    for (const double value : constants_)
        for (int i = 0; i < (type_.isa == InstructionSet::avx512 ? 1 : lanes); ++i) embed(value);
    a_.align(asmjit::AlignMode::kData, 64);
    a_.bind(lane_constants_label_);
    for (const auto& [value, lane] : lane_constants_)
        for (int i = 0; i < lanes; ++i) embed(i == lane ? value : 0);
    a_.align(asmjit::AlignMode::kData, 64);
    constants_.clear();
    lane_constants_.clear();
}

void VectorAssembler::move(int d, int from) {
    if (d == from) return;
    if (is_sse()) a_.movaps(reg(d).as<x86::Xmm>(), reg(from).as<x86::Xmm>());
    else a_.emit(I::kIdVmovaps, reg(d), reg(from));
}

void VectorAssembler::load_value(int d, const x86::Mem& from) {
    if (type_.lanes > 1) return load_register(d, from);
    if (is_sse()) a_.emit(by_precision(I::kIdMovsd, I::kIdMovss), reg(d), from);
    else a_.emit(by_precision(I::kIdVmovsd, I::kIdVmovss), reg(d), from);
}

void VectorAssembler::store_value(const x86::Mem& to, int from) {
    if (type_.lanes > 1) return store_register(to, from);
    if (is_sse()) a_.emit(by_precision(I::kIdMovsd, I::kIdMovss), to, reg(from));
    else a_.emit(by_precision(I::kIdVmovsd, I::kIdVmovss), to, reg(from));
}

void VectorAssembler::load_register(int d, const x86::Mem& from) {
    a_.emit(is_sse() ? I::kIdMovaps : I::kIdVmovaps, reg(d), from);
}

void VectorAssembler::store_register(const x86::Mem& to, int from) {
    a_.emit(is_sse() ? I::kIdMovaps : I::kIdVmovaps, to, reg(from));
}

void VectorAssembler::load_constant(int d, double value) {
    x86::Mem from = constant(value);
    if (type_.isa != InstructionSet::avx512) return load_register(d, from);
    from.resetBroadcast();
    load_number(d, from);
}

void VectorAssembler::load_number(int d, const x86::Mem& from) {
    if (is_sse()) {
        a_.emit(by_precision(I::kIdMovsd, I::kIdMovss), reg(d), from);
        if (is_double()) a_.emit(I::kIdUnpcklpd, reg(d), reg(d));
        else a_.emit(I::kIdShufps, reg(d), reg(d), asmjit::imm(0));
    } else if (register_size_ == 16 && is_double()) {
        a_.emit(I::kIdVmovddup, reg(d), from);  // no 128-bit vbroadcastsd exists
    } else {
        a_.emit(by_precision(I::kIdVbroadcastsd, I::kIdVbroadcastss), reg(d), from);
    }
}

void VectorAssembler::three_operands(Id avx, Id sse, int d, int a, const Operand& b) {
    if (!is_sse()) {
        a_.emit(avx, reg(d), reg(a), b);
        return;
    }
    if (d != a && number_of(b) == d) {  // the copy of a to d would overwrite b
        move(scratch(), a);
        a_.emit(sse, reg(scratch()), b);
        move(d, scratch());
        return;
    }
    move(d, a);
    a_.emit(sse, reg(d), b);
}

void VectorAssembler::binary(Binary op, int d, int a, const Operand& b) {
    const Ids& ids = binary_ids[int(op)];
    three_operands(by_precision(ids.avx_double, ids.avx_float), by_precision(ids.sse_double, ids.sse_float), d, a, b);
}

void VectorAssembler::sqrt(int d, const Operand& a) {
    if (is_sse()) a_.emit(by_precision(I::kIdSqrtpd, I::kIdSqrtps), reg(d), a);
    else a_.emit(by_precision(I::kIdVsqrtpd, I::kIdVsqrtps), reg(d), a);
}

void VectorAssembler::fused_into_c(Fused op, int c, int a, const Operand& b) {
    const FusedIds& ids = fused_ids[int(op)];
    a_.emit(by_precision(ids.into_c_double, ids.into_c_float), reg(c), reg(a), b);
}

void VectorAssembler::fused_into_a(Fused op, int a, int b, const Operand& c) {
    const FusedIds& ids = fused_ids[int(op)];
    a_.emit(by_precision(ids.into_a_double, ids.into_a_float), reg(a), reg(b), c);
}

void VectorAssembler::estimate_recip(int d, int a) {
    a_.emit(by_precision(I::kIdVrcp14pd, I::kIdVrcp14ps), reg(d), reg(a));
}

void VectorAssembler::estimate_rsqrt(int d, int a) {
    a_.emit(by_precision(I::kIdVrsqrt14pd, I::kIdVrsqrt14ps), reg(d), reg(a));
}

void VectorAssembler::compare(Condition condition, int mask, int a, int b) {
    const auto predicate = asmjit::imm(int(condition));
    const Id avx = by_precision(I::kIdVcmppd, I::kIdVcmpps);
    if (type_.isa == InstructionSet::avx512) {
        a_.emit(avx, x86::k1, reg(a), reg(b), predicate);
    } else if (type_.isa == InstructionSet::avx2) {
        a_.emit(avx, reg(mask), reg(a), reg(b), predicate);
    } else {
        move(mask, a);
        a_.emit(by_precision(I::kIdCmppd, I::kIdCmpps), reg(mask), reg(b), predicate);
    }
}

void VectorAssembler::blend(int d, int mask, int a, int b) {
    if (type_.isa == InstructionSet::avx512) {
        a_.k(x86::k1).emit(by_precision(I::kIdVblendmpd, I::kIdVblendmps), reg(d), reg(b), reg(a));
    } else if (type_.isa == InstructionSet::avx2) {
        a_.emit(by_precision(I::kIdVblendvpd, I::kIdVblendvps), reg(d), reg(b), reg(a), reg(mask));
    } else {  // (~mask & b) | (mask & a)
        move(scratch(), mask);
        a_.emit(I::kIdAndnps, reg(scratch()), reg(b));
        a_.emit(I::kIdAndps, reg(mask), reg(a));
        a_.emit(I::kIdOrps, reg(scratch()), reg(mask));
        move(d, scratch());
    }
}

void VectorAssembler::end_wide_registers() {
    if (!is_sse()) a_.vzeroupper();
}

}  // namespace kagero::compiler

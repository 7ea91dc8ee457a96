#include "compiler/asmjit/operation_writer.h"

#include <algorithm>
#include <utility>

namespace kagero::compiler {

void OperationWriter::write(int node) {
    if (const Call* function_call = program_.call(node)) return call(*function_call);
    const ProgramNode& n = program_[node];
    const int result = [&] {
        switch (n.op) {
            case Op::add: return commutative(Binary::add, n);
            case Op::sub: return subtract(n);
            case Op::mul: return commutative(Binary::mul, n);
            case Op::neg: return negate(n);
            case Op::fma: return fused(Fused::add, n);
            case Op::fms: return fused(Fused::sub, n);
            case Op::fnma: return fused(Fused::neg, n);
            case Op::sqrt: return square_root(n);
            case Op::recip:
            case Op::rsqrt: return reciprocal(n);
            case Op::min: return extremum(Binary::min, n);
            case Op::max: return extremum(Binary::max, n);
            case Op::if_positive: return gate(true, n);
            case Op::unless_positive: return gate(false, n);
            default: return at_least(n);
        }
    }();
    r_.define(node, result);
}

int OperationWriter::result_register(const ProgramNode& n) {
    r_.release_operands(n);
    return r_.take();
}

int OperationWriter::commutative(Binary op, const ProgramNode& n) {
    const bool exchange = r_.reads_from_memory(n.a) && !r_.reads_from_memory(n.b);
    const int a = r_.in_register(exchange ? n.b : n.a);
    const asmjit::Operand b = r_.source(exchange ? n.a : n.b);
    const int d = result_register(n);
    v_.binary(op, d, a, b);
    return d;
}

int OperationWriter::subtract(const ProgramNode& n) {
    const int a = r_.in_register(n.a);
    const asmjit::Operand b = r_.source(n.b);
    const int d = result_register(n);
    v_.binary(Binary::sub, d, a, b);
    return d;
}

int OperationWriter::negate(const ProgramNode& n) {
    const int a = r_.in_register(n.a), d = result_register(n);
    v_.binary(Binary::xor_, d, a, v_.constant(-0.0));
    return d;
}

int OperationWriter::square_root(const ProgramNode& n) {
    const int a = r_.in_register(n.a), d = result_register(n);
    v_.sqrt(d, v_.reg(a));
    return d;
}

/// A fused instruction replaces one of its operands. An operand that is not used later is replaced, if there is one,
/// and else a copy. At most one of the other operands is read from memory.
int OperationWriter::fused(Fused op, const ProgramNode& n) {
    if (!v_.has_fused()) return fused_as_two(op, n);
    const bool exchange = r_.reads_from_memory(n.a) && !r_.reads_from_memory(n.b);
    const int first = exchange ? n.b : n.a, second = exchange ? n.a : n.b;
    const int a = r_.in_register(first);
    const bool replaces_c = r_.is_last_use_in_register(n.c), copies_c = !replaces_c && r_.reads_from_memory(n.c);
    if (replaces_c || (copies_c && r_.reads_from_memory(second))) {
        const int c = replaces_c ? r_.in_register(n.c) : r_.take();
        if (!replaces_c) r_.load(c, n.c);
        const asmjit::Operand b = r_.source(second);
        v_.fused_into_c(op, c, a, b);
        r_.release_operands(n);
        return c;
    }
    const int b = r_.in_register(second);
    const asmjit::Operand c = r_.source(n.c);
    const bool replaces_a = r_.is_last_use_in_register(first), replaces_b = r_.is_last_use_in_register(second);
    if (replaces_a || replaces_b) {
        const int d = replaces_a ? a : b, other = replaces_a ? b : a;
        v_.fused_into_a(op, d, other, c);
        r_.release_operands(n);
        return d;
    }
    const int d = r_.take();
    if (copies_c) {
        r_.load(d, n.c);
        v_.fused_into_c(op, d, a, v_.reg(b));
    } else {
        v_.move(d, a);
        v_.fused_into_a(op, d, b, c);
    }
    return d;
}

/// Without fused instructions, the product is rounded.
int OperationWriter::fused_as_two(Fused op, const ProgramNode& n) {
    const int a = r_.in_register(n.a);
    const asmjit::Operand b = r_.source(n.b);
    const int c = r_.in_register(n.c), d = r_.take();
    v_.binary(Binary::mul, d, a, b);
    if (op == Fused::add) v_.binary(Binary::add, d, d, v_.reg(c));
    else if (op == Fused::sub) v_.binary(Binary::sub, d, d, v_.reg(c));
    else v_.binary(Binary::sub, d, c, v_.reg(d));
    r_.release_operands(n);
    return d;
}

/// 1/x or 1/√x. On AVX-512, an estimate with 14 bits is refined as in kernels/simd/lanes.h.
int OperationWriter::reciprocal(const ProgramNode& n) {
    const int x = r_.in_register(n.a);
    int d = -1;
    if (v_.has_estimates()) {
        d = n.op == Op::recip ? refined_recip(x) : refined_rsqrt(x);
    } else {
        d = r_.take();
        const int one = r_.take();
        if (n.op == Op::rsqrt) v_.sqrt(d, v_.reg(x));
        v_.load_constant(one, 1);
        v_.binary(Binary::div, one, one, v_.reg(n.op == Op::rsqrt ? d : x));
        v_.move(d, one);
    }
    r_.release_operands(n);
    return d;
}

/// With e = min(1 − x y, 1): y + y e (1 + e (1 + e)) in double, y + y e in float.
int OperationWriter::refined_recip(int x) {
    const int y = r_.take(), e = r_.take(), t = v_.scratch();
    v_.estimate_recip(y, x);
    v_.load_constant(e, 1);
    v_.fused_into_c(Fused::neg, e, x, v_.reg(y));
    v_.binary(Binary::min, e, e, v_.constant(1));
    if (v_.is_double()) {
        v_.binary(Binary::add, t, e, v_.constant(1));
        v_.fused_into_a(Fused::add, t, e, v_.constant(1));
        v_.binary(Binary::mul, e, y, v_.reg(e));
        v_.fused_into_c(Fused::add, y, e, v_.reg(t));
    } else {
        v_.binary(Binary::mul, e, y, v_.reg(e));
        v_.fused_into_c(Fused::add, y, e, v_.constant(1));
    }
    return y;
}

/// With e = min(1 − x y², 1): y + y e (1/2 + e (3/8 + 5/16 e)) in double, y + y e/2 in float.
int OperationWriter::refined_rsqrt(int x) {
    const int y = r_.take(), e = r_.take(), t = v_.scratch();
    v_.estimate_rsqrt(y, x);
    v_.binary(Binary::mul, t, x, v_.reg(y));
    v_.load_constant(e, 1);
    v_.fused_into_c(Fused::neg, e, t, v_.reg(y));
    v_.binary(Binary::min, e, e, v_.constant(1));
    if (v_.is_double()) {
        v_.load_constant(t, 0.375);
        v_.fused_into_c(Fused::add, t, e, v_.constant(0.3125));
        v_.fused_into_a(Fused::add, t, e, v_.constant(0.5));
        v_.binary(Binary::mul, e, y, v_.reg(e));
        v_.fused_into_c(Fused::add, y, e, v_.reg(t));
    } else {
        v_.binary(Binary::mul, e, y, v_.reg(e));
        v_.fused_into_c(Fused::add, y, e, v_.constant(0.5));
    }
    return y;
}

/// The minimum or maximum of a and b; a if a is NaN.
int OperationWriter::extremum(Binary op, const ProgramNode& n) {
    const int a = r_.in_register(n.a), b = r_.in_register(n.b), d = r_.take(), mask = r_.take();
    v_.binary(op, d, a, v_.reg(b));
    v_.compare(Condition::unordered, mask, a, a);
    v_.blend(d, mask, a, d);
    r_.release_operands(n);
    return d;
}

/// With the condition c = operand a: 0 or operand b, depending on whether c ≤ 0; c if c is NaN.
int OperationWriter::gate(bool passes_positive, const ProgramNode& n) {
    const int c = r_.in_register(n.a), b = r_.in_register(n.b), d = r_.take(), mask = r_.take(), zero = r_.take();
    v_.load_constant(zero, 0);
    v_.compare(Condition::less_equal, mask, c, zero);
    if (passes_positive) v_.blend(d, mask, zero, b);
    else v_.blend(d, mask, b, zero);
    v_.compare(Condition::unordered, mask, c, c);
    v_.blend(d, mask, c, d);
    r_.release_operands(n);
    return d;
}

/// 1 if b ≤ a, else 0.
int OperationWriter::at_least(const ProgramNode& n) {
    const int a = r_.in_register(n.a), b = r_.in_register(n.b), d = r_.take(), mask = r_.take(), zero = r_.take();
    v_.load_constant(d, 1);
    v_.load_constant(zero, 0);
    v_.compare(Condition::less_equal, mask, b, a);
    v_.blend(d, mask, d, zero);
    r_.release_operands(n);
    return d;
}

/// Calls a function of the kernel module, which may change all vector registers. Operands and results are on the stack.
void OperationWriter::call(const Call& function_call) {
    const int registers = v_.registers(), nodes = int(function_call.first.size());
    if (first_argument_ < 0) first_argument_ = r_.reserve_slots(most_operands * registers);
    for (int r = 0; r < registers; ++r) {
        // An operation that is the same for all registers has one node.
        const ProgramNode& n = program_[function_call.first[std::size_t(std::min(r, nodes - 1))]];
        int argument = first_argument_ + r;
        for (const int operand : {n.a, n.b, n.c}) {
            if (operand >= 0) copy_to_stack(operand, argument);
            argument += registers;
        }
    }
    r_.store_all();
    const x86::Gp pointers[] = {x86::rdi, x86::rsi, x86::rdx};
    for (int i = 0; i < most_operands; ++i) a_.lea(pointers[i], r_.stack_slot(first_argument_ + i * registers));
    a_.lea(x86::rcx, r_.define_in_memory(function_call.first));
    if (!function_call.second.empty()) a_.lea(x86::r8, r_.define_in_memory(function_call.second));
    a_.mov(x86::rax, asmjit::imm(reinterpret_cast<std::uintptr_t>(function_call.function)));
    a_.call(x86::rax);
    r_.forget_registers();
}

void OperationWriter::copy_to_stack(int node, int slot) {
    int reg = v_.scratch();
    if (r_.is_in_register(node)) reg = r_.in_register(node);
    else r_.load(reg, node);
    v_.store_register(r_.stack_slot(slot), reg);
}

}  // namespace kagero::compiler

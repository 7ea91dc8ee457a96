/// Evaluates code for any number type: packets of rays, single rays, and dual numbers of both.
#pragma once

#include "kernels/formula/code.h"
#include "kernels/autodiff/dual.h"

namespace kagero::formula {

/// Returns the address of a slot with N values, from the slot's offset in an instruction. `s` points to slot 0.
template <class T, int N>
KAGERO_INLINE T* slot_at(T* s, std::size_t offset) {
    constexpr std::size_t size = sizeof(T) * N;
    if constexpr (size % Instruction::offset_unit == 0) offset *= size / Instruction::offset_unit;
    else offset = offset / Instruction::offset_unit * size;
    return reinterpret_cast<T*>(reinterpret_cast<unsigned char*>(s) + offset);
}

/// Executes a run of one operation on N sets of slots: slot i of set n is s[i·N + n]. `instruction` points to the first
/// instruction of the run. `accumulator` receives the results of the last instruction.
template <Op op, class T, int N>
KAGERO_INLINE void run_op(const Instruction* instruction, const Run& run, T* s, T (&accumulator)[N]) {
    for (int i = 0; i < run.count; ++i) {
        const Instruction current = instruction[i];
        T* result = slot_at<T, N>(s, current.result);
        const T *a = slot_at<T, N>(s, current.a), *b = slot_at<T, N>(s, current.b), *c = slot_at<T, N>(s, current.c);
        for (int n = 0; n < N; ++n) accumulator[n] = kagero::detail::apply_total<op, true, T>(a[n], b[n], c[n]);
        if (run.stores_result)
            for (int n = 0; n < N; ++n) result[n] = accumulator[n];
    }
}
/// Executes a run of one operation on the accumulator.
template <AccumulatorOp op, class T, int N>
KAGERO_INLINE void run_accumulator_op(const Instruction* instruction, const Run& run, T* s, T (&accumulator)[N]) {
    for (int i = 0; i < run.count; ++i) {
        const Instruction current = instruction[i];
        const T *a = slot_at<T, N>(s, current.a), *b = slot_at<T, N>(s, current.b), *c = slot_at<T, N>(s, current.c);
        for (int n = 0; n < N; ++n) {
            if constexpr (op == AccumulatorOp::add) accumulator[n] = accumulator[n] + b[n];
            else if constexpr (op == AccumulatorOp::mul) accumulator[n] = accumulator[n] * b[n];
            else if constexpr (op == AccumulatorOp::rsqrt) accumulator[n] = total_rsqrt(accumulator[n]);
            else if constexpr (op == AccumulatorOp::recip) accumulator[n] = total_recip(accumulator[n]);
            else if constexpr (op == AccumulatorOp::fma) accumulator[n] = fma(accumulator[n], b[n], c[n]);
            else if constexpr (op == AccumulatorOp::add_product) accumulator[n] = fma(a[n], b[n], accumulator[n]);
            else if constexpr (op == AccumulatorOp::fnma) accumulator[n] = fnma(accumulator[n], b[n], c[n]);
            else accumulator[n] = fnma(a[n], b[n], accumulator[n]);
        }
    }
    T* result = slot_at<T, N>(s, instruction[run.count - 1].result);
    if (run.stores_result)
        for (int n = 0; n < N; ++n) result[n] = accumulator[n];
}

/// Executes runs [first, end) of a code on N sets of slots.
template <class T, int N>
__attribute__((noinline)) void interpret(const Code& code, int first, int end, T* s) {
    T accumulator[N];
    for (int n = 0; n < N; ++n) accumulator[n] = s[n];
    for (int r = first; r < end; ++r) {
        const Run run = code.run[r];
        const Instruction* instruction = code.instruction + run.first;
        switch (run.opcode) {
#define KAGERO_RUN(OP, OPERATION)                                           \
    case opcode_of(Op::OP):                                                 \
        if constexpr (!operations::OPERATION::is_abbreviation)              \
            run_op<Op::OP, T, N>(instruction, run, s, accumulator);         \
        break;
            KAGERO_OPERATIONS(KAGERO_RUN)
#undef KAGERO_RUN
#define KAGERO_RUN(OP)                                                                    \
    case opcode_of(AccumulatorOp::OP):                                                    \
        run_accumulator_op<AccumulatorOp::OP, T, N>(instruction, run, s, accumulator);    \
        break;
            KAGERO_RUN(add) KAGERO_RUN(mul) KAGERO_RUN(rsqrt) KAGERO_RUN(recip) KAGERO_RUN(fma) KAGERO_RUN(add_product)
            KAGERO_RUN(fnma) KAGERO_RUN(minus_product)
#undef KAGERO_RUN
            default: break;  // leaves are not instructions
        }
    }
}

/// Memory for the slots of one evaluation. It is not initialised, because no slot is read before it is written.
template <class T>
class Slots {
public:
    Slots() {}
    T* data() { return reinterpret_cast<T*>(memory_); }
    KAGERO_INLINE void fill_constants(const Code& code) {
        for (int i = 0; i < code.constants; ++i) data()[code.inputs + i] = T(code.constant[i]);
    }
    KAGERO_INLINE void fill_inputs(const Code& code, const T* in) {
        for (int i = 0; i < code.inputs; ++i) data()[i] = in[i];
    }
    KAGERO_INLINE void read(const Code& code, T* out) {
        for (int o = 0; o < code.outputs; ++o) out[o] = data()[code.output[o]];
    }

private:
    alignas(64) unsigned char memory_[sizeof(T) * Code::max_slots];
};

/// Evaluates a code by the interpreter, for the inputs `in`, and writes its outputs to `out`.
template <class T>
__attribute__((noinline)) void evaluate_interpreted(const Code& code, const T* in, T* out) {
    Slots<T> slots;
    slots.fill_constants(code);
    slots.fill_inputs(code, in);
    interpret<T, 1>(code, 0, code.runs, slots.data());
    slots.read(code, out);
}

/// Evaluates a code for the inputs `in` and writes its outputs to `out`. Uses its machine code if there is some.
template <class T>
KAGERO_INLINE void evaluate(const Code& code, const T* in, T* out) {
    const CompiledProgram* compiled = code.compiled_for<T>();
    if constexpr (is_interpreted<T>)
        if (!compiled) return evaluate_interpreted(code, in, out);
    compiled->evaluate(in, out, 1);
}

}  // namespace kagero::formula

/// Evaluates code over any number type: packets of rays, single rays, and duals of both.
#pragma once

#include "kernels/formula/code.h"
#include "kernels/autodiff/dual.h"

namespace kagero::formula {

/// The slot at a place of an instruction.
template <class T, int N>
KAGERO_INLINE T* at(T* s, std::size_t place) {
    constexpr std::size_t size = sizeof(T) * N;
    if constexpr (size % Instruction::unit == 0) place *= size / Instruction::unit;
    else place = place / Instruction::unit * size;
    return reinterpret_cast<T*>(reinterpret_cast<unsigned char*>(s) + place);
}

/// The same instruction on N sets of slots: slot i of set n is s[i·N + n]. `last` is left with the last results.
template <Op op, class T, int N>
KAGERO_INLINE void run_of(const Instruction* instruction, const Run& run, T* s, T (&last)[N]) {
    for (int i = 0; i < run.count; ++i) {
        const Instruction now = instruction[i];
        T* result = at<T, N>(s, now.result);
        const T *a = at<T, N>(s, now.a), *b = at<T, N>(s, now.b), *c = at<T, N>(s, now.c);
        for (int n = 0; n < N; ++n) last[n] = kagero::detail::apply_total<op, true, T>(a[n], b[n], c[n]);
        if (run.keep)
            for (int n = 0; n < N; ++n) result[n] = last[n];
    }
}
template <OnLast op, class T, int N>
KAGERO_INLINE void run_on_last(const Instruction* instruction, const Run& run, T* s, T (&last)[N]) {
    for (int i = 0; i < run.count; ++i) {
        const Instruction now = instruction[i];
        const T *a = at<T, N>(s, now.a), *b = at<T, N>(s, now.b), *c = at<T, N>(s, now.c);
        for (int n = 0; n < N; ++n) {
            if constexpr (op == OnLast::add) last[n] = last[n] + b[n];
            else if constexpr (op == OnLast::mul) last[n] = last[n] * b[n];
            else if constexpr (op == OnLast::rsqrt) last[n] = total_rsqrt(last[n]);
            else if constexpr (op == OnLast::recip) last[n] = total_recip(last[n]);
            else if constexpr (op == OnLast::fma) last[n] = fma(last[n], b[n], c[n]);
            else if constexpr (op == OnLast::add_product) last[n] = fma(a[n], b[n], last[n]);
            else if constexpr (op == OnLast::fnma) last[n] = fnma(last[n], b[n], c[n]);
            else last[n] = fnma(a[n], b[n], last[n]);
        }
    }
    T* result = at<T, N>(s, instruction[run.count - 1].result);
    if (run.keep)
        for (int n = 0; n < N; ++n) result[n] = last[n];
}

/// Runs [first, last) of a code.
template <class T, int N>
__attribute__((noinline)) void interpret(const Code& code, int first, int end, T* s) {
    T last[N];
    for (int n = 0; n < N; ++n) last[n] = s[n];
    for (int r = first; r < end; ++r) {
        const Run run = code.run[r];
        const Instruction* instruction = code.instruction + run.first;
        switch (run.kind) {
#define KAGERO_RUN(OP, OPERATION)                                                                               \
    case kind_of(Op::OP):                                                                                       \
        if constexpr (!operations::OPERATION::is_abbreviation) run_of<Op::OP, T, N>(instruction, run, s, last); \
        break;
            KAGERO_OPERATIONS(KAGERO_RUN)
#undef KAGERO_RUN
#define KAGERO_RUN(OP) \
    case kind_of(OnLast::OP): run_on_last<OnLast::OP, T, N>(instruction, run, s, last); break;
            KAGERO_RUN(add) KAGERO_RUN(mul) KAGERO_RUN(rsqrt) KAGERO_RUN(recip) KAGERO_RUN(fma) KAGERO_RUN(add_product)
            KAGERO_RUN(fnma) KAGERO_RUN(minus_product)
#undef KAGERO_RUN
            default: break;  // leaves are no instructions
        }
    }
}

/// Slots for an evaluation. Memory alone: nothing is read that was not written.
template <class T>
class Slots {
public:
    Slots() {}
    T* data() { return reinterpret_cast<T*>(memory_); }
    KAGERO_INLINE void fill_constants(const Code& code) {
        for (int i = 0; i < code.constants; ++i) data()[Code::inputs + i] = T(code.constant[i]);
    }
    KAGERO_INLINE void fill_inputs(const T* in) {
        for (int i = 0; i < Code::inputs; ++i) data()[i] = in[i];
    }
    KAGERO_INLINE void read(const Code& code, T* out) {
        for (int o = 0; o < code.outputs; ++o) out[o] = data()[code.output[o]];
    }

private:
    alignas(64) unsigned char memory_[sizeof(T) * Code::greatest_slots];
};

/// inputs → outputs.
template <class T>
__attribute__((noinline)) void evaluate(const Code& code, const T* in, T* out) {
    Slots<T> slots;
    slots.fill_constants(code);
    slots.fill_inputs(in);
    interpret<T, 1>(code, 0, code.runs, slots.data());
    slots.read(code, out);
}

}  // namespace kagero::formula

/// Evaluation of a formula's code several times: for several values of the varying inputs, or at several stages.
#pragma once

#include "kernels/formula/interpreter.h"

namespace kagero::formula {

/// A code that is evaluated several times, between which only the varying inputs change. The constructor executes the
/// instructions that do not depend on them.
template <class V>
class PreparedCode {
public:
    /// `in` contains all inputs of the code.
    PreparedCode(const Code& code, const V* in) : code_(code), compiled_(code.compiled_for<V>()) {
        slots_.fill_inputs(code, in);
        prepare();
    }
    PreparedCode(const PreparedCode&) = delete;
    PreparedCode& operator=(const PreparedCode&) = delete;
    /// Returns a reference to an input, which the caller may change if it is one of the varying inputs.
    KAGERO_INLINE V& input(int i) { return slots_.data()[i]; }
    /// Evaluates the code.
    KAGERO_INLINE void evaluate(V* out) {
        if constexpr (is_interpreted<V>)
            if (!compiled_) {
                interpret<V, 1>(code_, code_.prepared_runs, code_.runs, slots_.data());
                return slots_.read(code_, out);
            }
        compiled_->evaluate_prepared(slots_.data(), out, 1);
    }

private:
    void prepare() {
        if constexpr (is_interpreted<V>)
            if (!compiled_) {
                slots_.fill_constants(code_);
                return interpret<V, 1>(code_, 0, code_.prepared_runs, slots_.data());
            }
        if (compiled_->prepare) compiled_->prepare(slots_.data(), slots_.data() + code_.inputs, 1);
    }

    const Code& code_;
    const CompiledProgram* compiled_;  ///< the machine code, or nullptr
    Slots<V> slots_;                   ///< for machine code: the inputs, then the values of CompiledProgram::prepare
};

/// ∂K/∂q as a function of p, or ∂K/∂p as a function of q: p or q, respectively, are the varying inputs.
template <class V>
class PreparedGradient {
public:
    PreparedGradient(const Code& code, const State<V>& s, VaryingInputs varying)
        : code_(code, s.y), first_varying_(varying.first) {}
    Vec3<V> operator()(const Vec3<V>& varying_inputs) {
        code_.input(first_varying_) = varying_inputs.x;
        code_.input(first_varying_ + 1) = varying_inputs.y;
        code_.input(first_varying_ + 2) = varying_inputs.z;
        V out[3] = {};
        code_.evaluate(out);
        return {out[0], out[1], out[2]};
    }

private:
    PreparedCode<V> code_;
    int first_varying_;  ///< index of the first varying input
};

/// Evaluates ∂K/∂(q, p) at the `count` stages of a step. Machine code evaluates all stages in one call. The interpreter
/// evaluates groups of 4, 3 or 1 stages together, so that each instruction is decoded once per group; the constructor
/// then writes the constants once for all evaluations.
template <class V>
class StageEvaluator {
public:
    StageEvaluator(const Code& code, int count) : code_(code), compiled_(code.compiled_for<V>()), count_(count) {
        if (compiled_) lay_out_points();
        else lay_out_slots();
    }
    StageEvaluator(const StageEvaluator&) = delete;
    StageEvaluator& operator=(const StageEvaluator&) = delete;
    /// Returns a reference to input k of a stage.
    KAGERO_INLINE V& input(int stage, int k) { return values()[input_[stage] + k * stride_]; }
    /// Writes the derivatives at a stage to `out`.
    KAGERO_INLINE void read(int stage, V (&out)[phase_size]) {
        for (int k = 0; k < phase_size; ++k) out[k] = values()[first_output_[stage] + output_[k]];
    }
    /// Evaluates the derivatives at all stages.
    void run() {
        if constexpr (is_interpreted<V>)
            if (!compiled_) return run_interpreter();
        compiled_->evaluate(values(), values() + first_output_[0], std::uint64_t(count_));
    }

private:
    V* values() { return reinterpret_cast<V*>(memory_); }
    void run_interpreter() {
        for (int stage = 0; stage < count_; stage += stride_) {
            V* const slots = values() + input_[stage];
            if (stride_ == 4) interpret<V, 4>(code_, 0, code_.runs, slots);
            else if (stride_ == 3) interpret<V, 3>(code_, 0, code_.runs, slots);
            else interpret<V, 1>(code_, 0, code_.runs, slots);
        }
    }
    /// The layout for machine code: the inputs of all stages, then the outputs of all stages.
    void lay_out_points() {
        for (int stage = 0; stage < count_; ++stage) {
            input_[stage] = stage * state_size;
            first_output_[stage] = count_ * state_size + stage * phase_size;
        }
        for (int k = 0; k < phase_size; ++k) output_[k] = k;
    }
    /// The layout for the interpreter: one set of slots per group. Each slot has one value per stage of the group.
    void lay_out_slots() {
        stride_ = count_ % 4 == 0 ? 4 : count_ % 3 == 0 ? 3 : 1;
        for (int stage = 0; stage < count_; ++stage)
            input_[stage] = first_output_[stage] = stage / stride_ * stride_ * code_.slots + stage % stride_;
        for (int k = 0; k < phase_size; ++k) output_[k] = code_.output[k] * stride_;
        for (int group = 0; group < count_; group += stride_)
            for (int i = 0; i < code_.constants; ++i)
                for (int n = 0; n < stride_; ++n) input(group + n, code_.inputs + i) = V(code_.constant[i]);
    }

    const Code& code_;
    const CompiledProgram* compiled_;  ///< the machine code, or nullptr
    int count_;                        ///< number of stages
    int stride_ = 1;                   ///< distance between the slots of a stage; also the number of stages per group
    int input_[max_stages], first_output_[max_stages];  ///< per stage: index of its first input or output in memory
    int output_[phase_size];                            ///< per output: distance from the first output
    static constexpr int values_per_stage = is_interpreted<V> ? Code::max_slots : state_size + phase_size;
    alignas(64) unsigned char memory_[sizeof(V) * max_stages * values_per_stage];
};

}  // namespace kagero::formula

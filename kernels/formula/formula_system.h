/// The specialization of `System` for formulas. It interprets code instead of running compiled programs.
#pragma once

#include "kernels/formula/interpreter.h"
#include "kernels/formula/programs.h"

namespace kagero::formula {

/// The Hamiltonian type of all formulas. Steppers are compiled once for separable formulas and once for all others. The
/// type declares the part H_A for every formula, so that the recipe as printed is compiled; `Programs::parted` is true
/// if a formula declares parts.
template <bool separable>
struct AnyFormula {
    template <class V>
    struct Parameters {};
    template <class V>
    static V part_a(const Parameters<V>&, const Vec3<V>&, const Vec3<V>&, const V&);
};

/// ∂K/∂q as a function of p, or ∂K/∂p as a function of q: p or q, respectively, are the varying inputs. The constructor
/// executes the instructions that do not depend on them.
template <class V>
class PreparedGradient {
public:
    PreparedGradient(const Code& code, const State<V>& s, VaryingInputs varying)
        : code_(code), compiled_(code.compiled_for<V>()), first_varying_(varying.first) {
        slots_.fill_inputs(s.y);
        if (!compiled_) {
            slots_.fill_constants(code);
            interpret<V, 1>(code_, 0, code_.prepared_runs, slots_.data());
        } else if (compiled_->prepare) {
            compiled_->prepare(slots_.data(), slots_.data() + Code::inputs, 1);
        }
    }
    PreparedGradient(const PreparedGradient&) = delete;
    PreparedGradient& operator=(const PreparedGradient&) = delete;
    Vec3<V> operator()(const Vec3<V>& varying_inputs) {
        V* const in = slots_.data() + first_varying_;
        in[0] = varying_inputs.x;
        in[1] = varying_inputs.y;
        in[2] = varying_inputs.z;
        V out[3] = {};
        if (compiled_) {
            compiled_->evaluate_prepared(slots_.data(), out, 1);
        } else {
            interpret<V, 1>(code_, code_.prepared_runs, code_.runs, slots_.data());
            slots_.read(code_, out);
        }
        return {out[0], out[1], out[2]};
    }

private:
    const Code& code_;
    const CompiledProgram* compiled_;  ///< the machine code, or nullptr
    int first_varying_;                ///< index of the first varying input
    Slots<V> slots_;                   ///< for machine code: the inputs, then the values of CompiledProgram::prepare
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
        if (compiled_) return compiled_->evaluate(values(), values() + first_output_[0], std::uint64_t(count_));
        for (int stage = 0; stage < count_; stage += stride_) {
            V* const slots = values() + input_[stage];
            if (stride_ == 4) interpret<V, 4>(code_, 0, code_.runs, slots);
            else if (stride_ == 3) interpret<V, 3>(code_, 0, code_.runs, slots);
            else interpret<V, 1>(code_, 0, code_.runs, slots);
        }
    }

private:
    V* values() { return reinterpret_cast<V*>(memory_); }
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
                for (int n = 0; n < stride_; ++n) input(group + n, Code::inputs + i) = V(code_.constant[i]);
    }

    const Code& code_;
    const CompiledProgram* compiled_;  ///< the machine code, or nullptr
    int count_;                        ///< number of stages
    int stride_ = 1;                   ///< distance between the slots of a stage; also the number of stages per group
    int input_[max_stages], first_output_[max_stages];  ///< per stage: index of its first input or output in memory
    int output_[phase_size];                            ///< per output: distance from the first output
    alignas(64) unsigned char memory_[sizeof(V) * max_stages * Code::max_slots];
};

/// Writes a state as dual numbers, for the inputs of a program. Component k of their derivatives is the derivative with
/// respect to component first + k of the state (0 ≤ k < count).
template <int count, class V>
void make_dual_inputs(const State<V>& s, int first, Dual<V, count> (&in)[state_size]) {
    using DualNumber = Dual<V, count>;
    for (int k = 0; k < state_size; ++k)
        in[k] = k >= first && k < first + count ? DualNumber::variable(s.y[k], k - first) : DualNumber(s.y[k]);
}

/// The part H_A (index 0) or H_B (index 1), as a system.
class PartSystem {
public:
    static constexpr bool force_needs_p = true, velocity_needs_q = true;
    PartSystem(const Programs& programs, int index)
        : force_(programs.part_force[index]), velocity_(programs.part_velocity[index]) {}
    template <class V>
    Vec3<V> gradient_q(const State<V>& s) const { return gradient_half(force_, s); }
    template <class V>
    Vec3<V> gradient_p(const State<V>& s) const { return gradient_half(velocity_, s); }
    template <class V>
    void mixed(const State<V>& s, V* out) const { mixed_of(force_, s, out); }

    /// Returns the outputs of a code as a vector: ∂K/∂q or ∂K/∂p.
    template <class V>
    static Vec3<V> gradient_half(const Code& code, const State<V>& s) {
        V out[3] = {};
        evaluate(code, s.y, out);
        return {out[0], out[1], out[2]};
    }
    /// Computes ∂²K/∂q_i∂p_j (9 numbers, row by row), by forward-mode differentiation of the code of ∂K/∂q.
    template <class V>
    static void mixed_of(const Code& force, const State<V>& s, V* out) {
        using DualNumber = Dual<V, space_size>;
        DualNumber in[state_size], gradient[space_size];
        make_dual_inputs<space_size>(s, kick_varies.first, in);
        evaluate(force, in, gradient);
        for (int i = 0; i < space_size; ++i)
            for (int k = 0; k < space_size; ++k) out[space_size * i + k] = gradient[i].derivative[k];
    }

private:
    const Code &force_, &velocity_;
};

}  // namespace kagero::formula

namespace kagero {

/// A formula as a system for steppers. Time rescaling is a run-time property here, so that steppers are compiled once
/// for both cases.
template <class S>
class FormulaSystem {
    using Parts = formula::PartSystem;

public:
    // Assumed, because the formula is unknown at compile time.
    static constexpr bool separable = false, force_needs_p = true, velocity_needs_q = true;
    static constexpr Axes cyclic{};  // no coordinate is known to be cyclic
    bool rescaled;  ///< True with time rescaling.

    explicit FormulaSystem(const double* parameters)
        : rescaled(formula::programs_in(parameters).rescaled), programs_(formula::programs_in(parameters)),
          a_(programs_, 0), b_(programs_, 1) {}
    const Parts& part_a() const { return a_; }
    const Parts& part_b() const { return b_; }
    S level() const { return S(programs_.level); }

    /// Writes ∂K/∂(q, p).
    template <class V>
    void derivatives(const State<V>& s, V* out) const { formula::evaluate(programs_.derivatives, s.y, out); }
    /// Returns an object that computes ∂K/∂(q, p) at the stages of a step.
    template <class V>
    formula::StageEvaluator<V> derivatives_at(int stages) const { return {programs_.derivatives, stages}; }
    template <class V>
    Vec3<V> gradient_q(const State<V>& s) const { return Parts::gradient_half(programs_.force, s); }
    template <class V>
    Vec3<V> gradient_p(const State<V>& s) const { return Parts::gradient_half(programs_.velocity, s); }
    /// Returns ∂K/∂q at the position of s, as a function of p.
    template <class V>
    formula::PreparedGradient<V> prepared_force(const State<V>& s) const { return {programs_.force, s, kick_varies}; }
    /// Returns ∂K/∂p for the momentum of s, as a function of q.
    template <class V>
    formula::PreparedGradient<V> prepared_velocity(const State<V>& s) const {
        return {programs_.velocity, s, drift_varies};
    }
    template <class V>
    void mixed(const State<V>& s, V* out) const { Parts::mixed_of(programs_.force, s, out); }

    /// Computes ∂²K/∂(q, p)² row by row, by forward-mode differentiation of the code of ∂K/∂(q, p). Each of two
    /// evaluations yields the derivatives with respect to half of the variables.
    template <class V>
    void hessian(const State<V>& s, V* out) const {
        using DualNumber = Dual<V, space_size>;
        for (int first = 0; first < phase_size; first += space_size) {
            DualNumber in[state_size], g[phase_size];
            formula::make_dual_inputs<space_size>(s, first, in);
            formula::evaluate(programs_.derivatives, in, g);
            for (int i = 0; i < phase_size; ++i)
                for (int k = 0; k < space_size; ++k) out[phase_size * i + first + k] = g[i].derivative[k];
        }
    }

    /// Returns the program of ∂K/∂(q, p) as data.
    ProgramWithUniforms<S> derivatives_with_uniforms() const {
        const formula::Nodes& n = programs_.derivative_nodes;
        return {{n.nodes, nullptr, n.outputs, n.size}, nullptr};
    }

    /// Returns H − H0, without the factor Ω.
    template <class V>
    V unscaled_energy_residual(const State<V>& s) const {
        V out[1] = {};
        formula::evaluate(programs_.energy_residual, s.y, out);
        return out[0];
    }
    /// Returns ∂K/∂p_t = Ω ∂H/∂p_t.
    template <class V>
    V gradient_pt(const State<V>& s) const {
        Dual<V, space_size> in[state_size], out[1];
        formula::make_dual_inputs<space_size>(s, component_pt, in);
        formula::evaluate(programs_.energy_residual, in, out);
        return time_rescaling_factor(s) * out[0].derivative[0];
    }
    /// Returns ∂K/∂p and its derivative along n. The code is evaluated with the dual numbers of `hessian`.
    template <class V>
    Vec3<Dual<V, 1>> velocity_along(const State<V>& s, const Vec3<V>& n) const {
        using DualNumber = Dual<V, space_size>;
        DualNumber in[state_size], velocity[space_size];
        for (int k = 0; k < state_size; ++k) in[k] = DualNumber(s.y[k]);
        in[component_px].derivative[0] = n.x;
        in[component_py].derivative[0] = n.y;
        in[component_pz].derivative[0] = n.z;
        formula::evaluate(programs_.velocity, in, velocity);
        const auto first = [](const DualNumber& number) {
            Dual<V, 1> result(number.value);
            result.derivative[0] = number.derivative[0];
            return result;
        };
        return {first(velocity[0]), first(velocity[1]), first(velocity[2])};
    }
    /// Returns Ω; 1 without time rescaling.
    template <class V>
    V time_rescaling_factor(const State<V>& s) const {
        V out[1] = {V(S(1))};
        if (rescaled) formula::evaluate(programs_.time_rescaling_factor, s.y, out);
        return out[0];
    }
    /// Returns the switching function, which is zero on the kinks of H; 1 if H has none.
    template <class V>
    V switching_function(const State<V>& s) const {
        V out[1] = {V(S(1))};
        if (programs_.has_kinks) formula::evaluate(programs_.switching_function, s.y, out);
        return out[0];
    }
    /// Returns the event functions at s.
    template <class V>
    EventFunctions<V> event_functions(const State<V>& s) const {
        V out[formula::formula_function_count];
        formula::evaluate(programs_.event_functions, s.y, out);
        if (!programs_.bounds_steps) out[index_max_step_length] = V(std::numeric_limits<S>::max());
        // A ray that neither ends in this state nor can continue gets the velocity NaN, so that it fails. A ray cannot
        // continue where `domain` or `captured` is NaN, or where the step bound or Ω is not positive.
        const V zero(S(0)), &domain = out[index_domain], &captured = out[index_captured];
        const MaskOf<V> ends = (domain <= zero) | (captured <= zero);
        MaskOf<V> continues = (domain > zero) & (captured > zero) & (out[index_max_step_length] > zero);
        if (rescaled) continues = continues & (out[formula::index_time_rescaling] > zero);
        const MaskOf<V> defined = ends | continues;
        for (int k = index_velocity; k < index_energy_residual; ++k)
            out[k] = select(defined, out[k], V(std::numeric_limits<S>::quiet_NaN()));
        return event_functions_of(out);
    }

private:
    const formula::Programs& programs_;
    Parts a_, b_;
};

/// A separable formula, for steppers that evaluate ∂K/∂q and ∂K/∂p separately.
template <class S>
struct SeparableFormula : FormulaSystem<S> {
    using FormulaSystem<S>::FormulaSystem;
    static constexpr bool separable = true, force_needs_p = false, velocity_needs_q = false;
};

template <bool is_separable, bool Rescaled, class S>
struct System<formula::AnyFormula<is_separable>, Rescaled, S>
    : std::conditional_t<is_separable, SeparableFormula<S>, FormulaSystem<S>> {
    /// The base class for steppers that evaluate ∂K/∂q and ∂K/∂p separately.
    using SplitGradientBase = std::conditional_t<is_separable, SeparableFormula<S>, FormulaSystem<S>>;
    /// The base class for other steppers.
    using CommonBase = FormulaSystem<S>;
    using SplitGradientBase::SplitGradientBase;
    using Hamiltonian = formula::AnyFormula<is_separable>;
    static constexpr bool rescaled = Rescaled;
    static constexpr bool bounded = true, capturing = true, discontinuous = false, bounds_steps = true;
    static constexpr ProgramOperations operations{};  // the operations are unknown at compile time
};

}  // namespace kagero

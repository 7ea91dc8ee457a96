/// The specialization of `System` for formulas. It interprets code instead of running compiled programs.
#pragma once

#include "kernels/formula/interpreter.h"
#include "kernels/formula/programs.h"

namespace kagero::formula {

/// The Hamiltonian type of all formulas. Steppers are compiled once for separable formulas and once for all others. The
/// type declares parts H_A and H_B for every formula; `Programs::parted` is true if a formula has them.
template <bool separable>
struct AnyFormula {
    template <class V>
    struct Parameters {};
    template <class V>
    static V part_a(const Parameters<V>&, const Vec3<V>&, const Vec3<V>&, const V&);
};

/// ∂K/∂q as a function of p, or ∂K/∂p as a function of q. The constructor evaluates the part of the code that does not
/// depend on this varying input.
template <class V>
class PreparedGradient {
public:
    PreparedGradient(const Code& code, const State<V>& s, Varying varying) : code_(code), first_(varying.first) {
        slots_.fill_constants(code);
        slots_.fill_inputs(s.y);
        interpret<V, 1>(code_, 0, code_.prepared, slots_.data());
    }
    PreparedGradient(const PreparedGradient&) = delete;
    PreparedGradient& operator=(const PreparedGradient&) = delete;
    Vec3<V> operator()(const Vec3<V>& varying) {
        V* const in = slots_.data() + first_;
        in[0] = varying.x;
        in[1] = varying.y;
        in[2] = varying.z;
        interpret<V, 1>(code_, code_.prepared, code_.runs, slots_.data());
        V out[3] = {};
        slots_.read(code_, out);
        return {out[0], out[1], out[2]};
    }

private:
    const Code& code_;
    int first_;
    Slots<V> slots_;
};

/// Evaluates ∂K/∂(q, p) at the `count` stages of a step. Groups of 4, 3 or 1 stages are evaluated together, so that
/// each instruction is decoded once per group. The constructor writes the constants once for many evaluations.
template <class V>
class StageEvaluator {
public:
    StageEvaluator(const Code& code, int count)
        : code_(code), groups_(count % 4 == 0   ? count / 4
                               : count % 3 == 0 ? count / 3
                                                : count),
          group_size_(count / groups_) {
        for (int g = 0; g < groups_; ++g)
            for (int i = 0; i < code.constants; ++i)
                for (int n = 0; n < group_size_; ++n) slot(g, Code::inputs + i)[n] = V(code.constant[i]);
    }
    StageEvaluator(const StageEvaluator&) = delete;
    StageEvaluator& operator=(const StageEvaluator&) = delete;
    /// Returns a reference to input k of a stage.
    KAGERO_INLINE V& input(int stage, int k) { return slot(stage / group_size_, k)[stage % group_size_]; }
    /// Writes the derivatives at a stage to `out`.
    KAGERO_INLINE void read(int stage, V (&out)[phase_size]) {
        for (int k = 0; k < phase_size; ++k) out[k] = slot(stage / group_size_, code_.output[k])[stage % group_size_];
    }
    /// Evaluates the derivatives at all stages.
    void run() {
        for (int g = 0; g < groups_; ++g) {
            if (group_size_ == 4) interpret<V, 4>(code_, 0, code_.runs, slot(g, 0));
            else if (group_size_ == 3) interpret<V, 3>(code_, 0, code_.runs, slot(g, 0));
            else interpret<V, 1>(code_, 0, code_.runs, slot(g, 0));
        }
    }

private:
    /// Returns the address of slot k of a group: one value per stage of the group.
    V* slot(int group, int k) { return reinterpret_cast<V*>(memory_) + (group * code_.slots + k) * group_size_; }

    const Code& code_;
    int groups_, group_size_;
    alignas(64) unsigned char memory_[sizeof(V) * max_stages * Code::max_slots];
};

/// Writes a state as dual numbers, as inputs of a program. Their derivatives are those with respect to the components
/// from … from + count − 1 of the state.
template <int count, class V>
void make_dual_inputs(const State<V>& s, int from, Dual<V, count> (&in)[state_size]) {
    using Forward = Dual<V, count>;
    for (int k = 0; k < state_size; ++k)
        in[k] = k >= from && k < from + count ? Forward::variable(s.y[k], k - from) : Forward(s.y[k]);
}

/// One of the two parts H_A and H_B, as a system.
class PartSystem {
public:
    static constexpr bool force_needs_p = true, velocity_needs_q = true;
    PartSystem(const Programs& programs, int which)
        : force_(programs.part_force[which]), velocity_(programs.part_velocity[which]) {}
    template <class V>
    Vec3<V> dq(const State<V>& s) const { return gradient_half(force_, s); }
    template <class V>
    Vec3<V> dp(const State<V>& s) const { return gradient_half(velocity_, s); }
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
        using Forward = Dual<V, space_size>;
        Forward in[state_size], halves[space_size];
        make_dual_inputs<space_size>(s, kick_varies.first, in);
        evaluate(force, in, halves);
        for (int i = 0; i < space_size; ++i)
            for (int k = 0; k < space_size; ++k) out[space_size * i + k] = halves[i].derivative[k];
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
    static constexpr bool separable = false, force_needs_p = true, velocity_needs_q = true;
    static constexpr Axes cyclic{};  // cyclic coordinates are unknown at compile time
    bool rescaled;

    explicit FormulaSystem(const double* parameters)
        : rescaled(formula::programs_in(parameters).rescaled), p_(formula::programs_in(parameters)), a_(p_, 0),
          b_(p_, 1) {}
    const Parts& part_a() const { return a_; }
    const Parts& part_b() const { return b_; }
    S level() const { return S(p_.level); }

    template <class V>
    void derivatives(const State<V>& s, V* out) const { formula::evaluate(p_.derivatives, s.y, out); }
    /// Returns an object that computes ∂K/∂(q, p) at the stages of a step.
    template <class V>
    formula::StageEvaluator<V> derivatives_at(int stages) const { return {p_.derivatives, stages}; }
    template <class V>
    Vec3<V> dq(const State<V>& s) const { return Parts::gradient_half(p_.force, s); }
    template <class V>
    Vec3<V> dp(const State<V>& s) const { return Parts::gradient_half(p_.velocity, s); }
    /// Returns ∂K/∂q at the position of s, as a function of p.
    template <class V>
    formula::PreparedGradient<V> prepared_force(const State<V>& s) const { return {p_.force, s, kick_varies}; }
    /// Returns ∂K/∂p for the momentum of s, as a function of q.
    template <class V>
    formula::PreparedGradient<V> prepared_velocity(const State<V>& s) const { return {p_.velocity, s, drift_varies}; }
    template <class V>
    void mixed(const State<V>& s, V* out) const { Parts::mixed_of(p_.force, s, out); }

    /// Computes ∂²K/∂(q, p)² row by row, by forward-mode differentiation of the code of ∂K/∂(q, p). Each of two
    /// evaluations yields the derivatives with respect to half of the variables.
    template <class V>
    void hessian(const State<V>& s, V* out) const {
        using Forward = Dual<V, space_size>;
        for (int from = 0; from < phase_size; from += space_size) {
            Forward in[state_size], g[phase_size];
            formula::make_dual_inputs<space_size>(s, from, in);
            formula::evaluate(p_.derivatives, in, g);
            for (int i = 0; i < phase_size; ++i)
                for (int k = 0; k < space_size; ++k) out[phase_size * i + from + k] = g[i].derivative[k];
        }
    }

    /// Returns the program of ∂K/∂(q, p) as data.
    ListingWithValues<S> derivatives_listing() const {
        const formula::Nodes& n = p_.derivative_nodes;
        return {{n.nodes, nullptr, n.outputs, n.size}, nullptr};
    }

    /// Returns H − H0.
    template <class V>
    V energy(const State<V>& s) const {
        V out[1] = {};
        formula::evaluate(p_.value, s.y, out);
        return out[0];
    }
    /// Returns Ω.
    template <class V>
    V time_rescaling_factor(const State<V>& s) const {
        V out[1] = {V(S(1))};
        if (rescaled) formula::evaluate(p_.time_rescaling_factor, s.y, out);
        return out[0];
    }
    template <class V>
    EventFunctions<V> event_functions(const State<V>& s) const {
        V out[formula::formula_function_count];
        formula::evaluate(p_.event_functions, s.y, out);
        if (!p_.bounds_steps) out[index_max_step_length] = V(std::numeric_limits<S>::max());
        // A ray that neither ends here nor can continue gets the velocity NaN, so that it fails. A ray cannot continue
        // where `domain` or `capture` is NaN, or where the step bound or Ω is not positive.
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
    const formula::Programs& p_;
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

/// A formula of a scene in the place of a compiled Hamiltonian: what `System` promises, by interpreting code.
#pragma once

#include "kernels/formula/interpreter.h"
#include "kernels/formula/programs.h"

namespace kagero::formula {

/// Stands for the Hamiltonian. Separable ones have steps of their own; all may have parts, which `Programs::parted`
/// knows.
template <bool separable>
struct AnyFormula {
    template <class V>
    struct Parameters {};
    template <class V>
    static V part_a(const Parameters<V>&, const Vec3<V>&, const Vec3<V>&, const V&);
};

/// Force or velocity as a function of what varies, the rest being evaluated already. Neither copied nor kept.
template <class V>
class Prepared {
public:
    Prepared(const Code& code, const State<V>& s, Varying varying) : code_(code), first_(varying.first) {
        slots_.fill_constants(code);
        slots_.fill_inputs(s.y);
        interpret<V, 1>(code_, 0, code_.prepared, slots_.data());
    }
    Prepared(const Prepared&) = delete;
    Prepared& operator=(const Prepared&) = delete;
    Vec3<V> operator()(const Vec3<V>& varying) {
        V* const in = slots_.data() + first_;
        in[0] = varying.x, in[1] = varying.y, in[2] = varying.z;
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

/// All derivatives at the stages of a step, several stages at a time, again and again: the constants are put in place
/// once. Neither copied nor kept.
template <class V>
class Stages {
public:
    Stages(const Code& code, int count)
        : code_(code), groups_(count % 4 == 0   ? count / 4
                               : count % 3 == 0 ? count / 3
                                                : count),
          together_(count / groups_) {
        for (int g = 0; g < groups_; ++g)
            for (int i = 0; i < code.constants; ++i)
                for (int n = 0; n < together_; ++n) place(g, Code::inputs + i)[n] = V(code.constant[i]);
    }
    Stages(const Stages&) = delete;
    Stages& operator=(const Stages&) = delete;
    KAGERO_INLINE V& input(int stage, int k) { return place(stage / together_, k)[stage % together_]; }
    KAGERO_INLINE void read(int stage, V (&out)[phase_size]) {
        for (int k = 0; k < phase_size; ++k) out[k] = place(stage / together_, code_.output[k])[stage % together_];
    }
    void run() {
        for (int g = 0; g < groups_; ++g) {
            if (together_ == 4) interpret<V, 4>(code_, 0, code_.runs, place(g, 0));
            else if (together_ == 3) interpret<V, 3>(code_, 0, code_.runs, place(g, 0));
            else interpret<V, 1>(code_, 0, code_.runs, place(g, 0));
        }
    }

private:
    V* place(int group, int slot) { return reinterpret_cast<V*>(memory_) + (group * code_.slots + slot) * together_; }

    const Code& code_;
    int groups_, together_;
    alignas(64) unsigned char memory_[sizeof(V) * max_stages * Code::greatest_slots];
};

/// A state as inputs of a program, `count` of its components from the given one on being variables.
template <int count, class V>
void along(const State<V>& s, int from, Dual<V, count> (&in)[state_size]) {
    using Forward = Dual<V, count>;
    for (int k = 0; k < state_size; ++k)
        in[k] = k >= from && k < from + count ? Forward::variable(s.y[k], k - from) : Forward(s.y[k]);
}

/// One of the two parts H_A and H_B.
class PartSystem {
public:
    static constexpr bool force_needs_p = true, velocity_needs_q = true;
    PartSystem(const Programs& programs, int which)
        : force_(programs.part_force[which]), velocity_(programs.part_velocity[which]) {}
    template <class V>
    Vec3<V> dq(const State<V>& s) const { return side(force_, s); }
    template <class V>
    Vec3<V> dp(const State<V>& s) const { return side(velocity_, s); }
    template <class V>
    void mixed(const State<V>& s, V* out) const { mixed_of(force_, s, out); }

    template <class V>
    static Vec3<V> side(const Code& code, const State<V>& s) {
        V out[3] = {};
        evaluate(code, s.y, out);
        return {out[0], out[1], out[2]};
    }
    /// ∂²K/∂q_i∂p_j (9, row by row): forward duals over the reverse program.
    template <class V>
    static void mixed_of(const Code& force, const State<V>& s, V* out) {
        using Forward = Dual<V, space_size>;
        Forward in[state_size], sides[space_size];
        along<space_size>(s, kick_varies.first, in);
        evaluate(force, in, sides);
        for (int i = 0; i < space_size; ++i)
            for (int k = 0; k < space_size; ++k) out[space_size * i + k] = sides[i].derivative[k];
    }

private:
    const Code &force_, &velocity_;
};

}  // namespace kagero::formula

namespace kagero {

/// A formula, rescaled or not: what steps see, so that they are compiled for both at once.
template <class S>
class FormulaSystem {
    using Parts = formula::PartSystem;

public:
    static constexpr bool separable = false, force_needs_p = true, velocity_needs_q = true;
    static constexpr Axes cyclic{};  // known to its programs alone
    bool rescaled;

    explicit FormulaSystem(const double* parameters)
        : rescaled(formula::programs_in(parameters).rescaled), p_(formula::programs_in(parameters)), a_(p_, 0),
          b_(p_, 1) {}
    const Parts& part_a() const { return a_; }
    const Parts& part_b() const { return b_; }
    S level() const { return S(p_.level); }

    template <class V>
    void derivatives(const State<V>& s, V* out) const { formula::evaluate(p_.derivatives, s.y, out); }
    /// The same at the stages of a step.
    template <class V>
    formula::Stages<V> derivatives_at(int stages) const { return {p_.derivatives, stages}; }
    template <class V>
    Vec3<V> dq(const State<V>& s) const { return Parts::side(p_.force, s); }
    template <class V>
    Vec3<V> dp(const State<V>& s) const { return Parts::side(p_.velocity, s); }
    /// ∂K/∂q at the position in s, as a function of p.
    template <class V>
    formula::Prepared<V> prepared_force(const State<V>& s) const { return {p_.force, s, kick_varies}; }
    /// ∂K/∂p with the momentum in s, as a function of q.
    template <class V>
    formula::Prepared<V> prepared_velocity(const State<V>& s) const { return {p_.velocity, s, drift_varies}; }
    template <class V>
    void mixed(const State<V>& s, V* out) const { Parts::mixed_of(p_.force, s, out); }

    /// ∂²K/∂(q, p)² row by row: forward duals over the reverse program, half of the variables at a time.
    template <class V>
    void hessian(const State<V>& s, V* out) const {
        using Forward = Dual<V, space_size>;
        for (int from = 0; from < phase_size; from += space_size) {
            Forward in[state_size], g[phase_size];
            formula::along<space_size>(s, from, in);
            formula::evaluate(p_.derivatives, in, g);
            for (int i = 0; i < phase_size; ++i)
                for (int k = 0; k < space_size; ++k) out[phase_size * i + from + k] = g[i].derivative[k];
        }
    }

    Listed<S> listed() const {
        const formula::Nodes& n = p_.derivative_nodes;
        return {{n.nodes, nullptr, n.outputs, n.size}, nullptr};
    }

    template <class V>
    V energy(const State<V>& s) const {
        V out[1] = {};
        formula::evaluate(p_.value, s.y, out);
        return out[0];
    }
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
        // There is no ray within the medium where formulas do not tell whether it ends or goes on, nor by steps of no
        // length, nor where it is rescaled by Ω ≤ 0: backward, or nowhere.
        const V zero(S(0)), &domain = out[index_domain], &captured = out[index_captured];
        const MaskOf<V> ends = (domain <= zero) | (captured <= zero);
        MaskOf<V> goes_on = (domain > zero) & (captured > zero) & (out[index_max_step_length] > zero);
        if (rescaled) goes_on = goes_on & (out[formula::index_time_rescaling] > zero);
        const MaskOf<V> stated = ends | goes_on;
        for (int k = index_velocity; k < index_excess; ++k)
            out[k] = select(stated, out[k], V(std::numeric_limits<S>::quiet_NaN()));
        return event_functions_of(out);
    }

private:
    const formula::Programs& p_;
    Parts a_, b_;
};

/// The same of a separable one, for steps that take one side of the equations at a time.
template <class S>
struct SeparableFormula : FormulaSystem<S> {
    using FormulaSystem<S>::FormulaSystem;
    static constexpr bool separable = true, force_needs_p = false, velocity_needs_q = false;
};

template <bool is_separable, bool Rescaled, class S>
struct System<formula::AnyFormula<is_separable>, Rescaled, S>
    : std::conditional_t<is_separable, SeparableFormula<S>, FormulaSystem<S>> {
    using OneSided = std::conditional_t<is_separable, SeparableFormula<S>, FormulaSystem<S>>;
    using Whole = FormulaSystem<S>;
    using OneSided::OneSided;
    using Hamiltonian = formula::AnyFormula<is_separable>;
    static constexpr bool rescaled = Rescaled;
    static constexpr bool bounded = true, capturing = true, discontinuous = false, bounds_steps = true;
    static constexpr ProgramOperations operations{};  // known to its programs alone
};

}  // namespace kagero

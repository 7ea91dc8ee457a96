/// The specialization of `System` for formulas. It runs the machine code of a formula, or interprets its code if there
/// is none.
#pragma once

#include "kernels/formula/evaluators.h"
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

/// Writes a state as dual numbers, for the inputs of a program. Component k of their derivatives is the derivative with
/// respect to component first + k of the state (0 ≤ k < count).
template <int count, class V>
void make_dual_inputs(const State<V>& s, int first, Dual<V, count> (&in)[state_size]) {
    using DualNumber = Dual<V, count>;
    for (int k = 0; k < state_size; ++k)
        in[k] = k >= first && k < first + count ? DualNumber::variable(s.y[k], k - first) : DualNumber(s.y[k]);
}

/// Evaluates a code with dual numbers, whose derivatives are those by three components of the state from `first` on.
/// The result has `n` outputs. Instead of packets without an interpreter, default packets with the same registers are
/// evaluated.
template <int n, class V>
void evaluate_dual(const Code& code, const State<V>& s, int first, Dual<V, space_size> (&out)[n]) {
    if constexpr (is_interpreted<V>) {
        Dual<V, space_size> in[state_size];
        make_dual_inputs<space_size>(s, first, in);
        evaluate(code, in, out);
    } else {
        using Packet = Lanes<ScalarOf<V>, 2>;
        constexpr int registers = ValueTraits<V>::registers;
        for (int r = 0; r < registers; r += 2) {
            const int second = r + 1 < registers ? r + 1 : r;
            State<Packet> part;
            for (int k = 0; k < state_size; ++k) {
                part.y[k].v[0] = s.y[k].v[r];
                part.y[k].v[1] = s.y[k].v[second];
            }
            Dual<Packet, space_size> result[n];
            evaluate_dual(code, part, first, result);
            const auto copy = [&](V& to, const Packet& from) {
                to.v[r] = from.v[0];
                if (second > r) to.v[second] = from.v[1];
            };
            for (int o = 0; o < n; ++o) {
                copy(out[o].value, result[o].value);
                for (int k = 0; k < space_size; ++k) copy(out[o].derivative[k], result[o].derivative[k]);
            }
        }
    }
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
        Dual<V, space_size> gradient[space_size];
        evaluate_dual(force, s, kick_varies.first, gradient);
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
        for (int first = 0; first < phase_size; first += space_size) {
            Dual<V, space_size> g[phase_size];
            formula::evaluate_dual(programs_.derivatives, s, first, g);
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
        Dual<V, space_size> out[1];
        formula::evaluate_dual(programs_.energy_residual, s, component_pt, out);
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
    /// Returns the switching function, which is zero on the kinks and discontinuities of H; 1 if H has none.
    template <class V>
    V switching_function(const State<V>& s) const {
        V out[1] = {V(S(1))};
        if (programs_.has_kinks || programs_.discontinuous)
            formula::evaluate(programs_.switching_function, s.y, out);
        return out[0];
    }
    /// Returns the event functions at s.
    template <class V>
    EventFunctions<V> event_functions(const State<V>& s) const {
        V out[formula::formula_function_count];
        formula::evaluate(programs_.event_functions, s.y, out);
        return checked_event_functions(out);
    }

protected:
    /// Returns the event functions for the outputs of their program.
    template <class V>
    EventFunctions<V> checked_event_functions(V (&out)[formula::formula_function_count]) const {
        if (!programs_.bounds_steps) out[index_max_step_length] = V(std::numeric_limits<S>::max());
        // A ray that neither ends in this state nor can continue gets the velocity NaN, so that it fails. A ray cannot
        // continue where `domain` or `captured` of a formula is NaN, or where the step bound or Ω is not positive. The
        // functions of a compiled Hamiltonian may be NaN where rays are neither captured nor escape.
        const V zero(S(0)), &domain = out[index_domain], &captured = out[index_captured];
        const MaskOf<V> ends = (domain <= zero) | (captured <= zero);
        MaskOf<V> continues = all_lanes<V>();
        if (!programs_.is_compiled_hamiltonian)
            continues = (domain > zero) & (captured > zero) & (out[index_max_step_length] > zero);
        if (rescaled) continues = continues & (out[formula::index_time_rescaling] > zero);
        const MaskOf<V> defined = ends | continues;
        for (int k = index_velocity; k < index_energy_residual; ++k)
            out[k] = select(defined, out[k], V(std::numeric_limits<S>::quiet_NaN()));
        return event_functions_of(out);
    }
    const formula::Programs& programs_;

private:
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

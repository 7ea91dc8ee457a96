/// Formulas whose lanes have different values of the parameters, for sweeps (lane_system.h).
#pragma once

#include "kernels/formula/formula_system.h"

#include <algorithm>

namespace kagero {

/// The programs of a formula with the parameters of the rays in the lanes of a packet. A pointer to this object is
/// passed in place of the parameters of a Hamiltonian. Values that depend only on the parameters are computed once per
/// packet.
template <class V>
class LaneFormula {
    using Code = formula::Code;
    using PreparedCode = formula::PreparedCode<V>;

public:
    /// `numbers` is LaneNumbers::numbers.
    LaneFormula(const formula::Programs& p, const double (*numbers)[lane_count<V>])
        : programs(p), inputs_(numbers, p.parameters), derivatives(p.derivatives, inputs_.value),
          event_functions(p.event_functions, inputs_.value), switching_function(p.switching_function, inputs_.value) {}

    /// Evaluates a prepared code at the state s.
    KAGERO_INLINE static void evaluate(PreparedCode& code, const State<V>& s, V* out) {
        for (int i = 0; i < state_size; ++i) code.input(i) = s.y[i];
        code.evaluate(out);
    }
    /// Evaluates any code for the state `in`, with dual numbers, for example.
    template <class Number>
    void evaluate(const Code& code, const Number (&in)[state_size], Number* out) const {
        Number all[Code::max_inputs];
        std::copy_n(in, state_size, all);
        for (int i = state_size; i < state_size + programs.parameters; ++i) all[i] = Number(inputs_.value[i]);
        formula::evaluate(code, all, out);
    }

    const formula::Programs& programs;

private:
    /// The inputs of a code. Those of the state are 0.
    struct Inputs {
        V value[Code::max_inputs] = {};
        Inputs(const double (*numbers)[lane_count<V>], int parameters) {
            for (int i = 0; i < parameters; ++i) value[state_size + i] = lanes_of<V>(numbers[i]);
        }
    };
    Inputs inputs_;

public:
    PreparedCode derivatives, event_functions, switching_function;
};

/// A formula as a system whose lanes have their own parameters. It supports only explicit Runge–Kutta methods.
template <class V>
class LaneFormulaSystem : public FormulaSystem<ScalarOf<V>> {
    using S = ScalarOf<V>;
    using Base = FormulaSystem<S>;

public:
    using Hamiltonian = formula::AnyFormula<false>;
    static constexpr bool called = true;  // steppers that exist for all called systems serve this system too
    static constexpr bool rescaled = false, force_needs_p = false, velocity_needs_q = false;
    static constexpr bool bounded = true, capturing = true, discontinuous = false, bounds_steps = true;
    static constexpr ProgramOperations operations{};  // the operations are unknown at compile time

    /// `parameters` points to the LaneFormula.
    explicit LaneFormulaSystem(const double* parameters)
        : Base(reinterpret_cast<const double*>(&lanes_in(parameters).programs)), lanes_(lanes_in(parameters)) {}
    void hessian(const State<V>&, V*) const = delete;

    /// Writes ∂H/∂(q, p).
    KAGERO_INLINE void derivatives(const State<V>& s, V* out) const { lanes_.evaluate(lanes_.derivatives, s, out); }
    /// Returns H − H0.
    V unscaled_energy_residual(const State<V>& s) const {
        V out[1] = {};
        lanes_.evaluate(this->programs_.energy_residual, s.y, out);
        return out[0];
    }
    /// Returns ∂H/∂p_t.
    template <class U>
    U gradient_pt(const State<U>& s) const {
        Dual<U, 1> in[state_size], out[1];
        formula::make_dual_inputs<1>(s, component_pt, in);
        lanes_.evaluate(this->programs_.energy_residual, in, out);
        return out[0].derivative[0];
    }
    V time_rescaling_factor(const State<V>&) const { return V(S(1)); }
    /// Returns the switching function, which is zero on the kinks of H.
    V switching_function(const State<V>& s) const {
        V out[1] = {};
        lanes_.evaluate(lanes_.switching_function, s, out);
        return out[0];
    }
    /// Returns the event functions at s.
    EventFunctions<V> event_functions(const State<V>& s) const {
        V out[formula::formula_function_count];
        lanes_.evaluate(lanes_.event_functions, s, out);
        return this->checked_event_functions(out);
    }

private:
    static LaneFormula<V>& lanes_in(const double* parameters) {
        return *reinterpret_cast<LaneFormula<V>*>(const_cast<double*>(parameters));
    }

    LaneFormula<V>& lanes_;
};

}  // namespace kagero

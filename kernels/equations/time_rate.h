/// The derivative of K by p_t, whose integral over τ is the coordinate time of a spacetime: dt/dλ = ∂H/∂p_t.
#pragma once

#include "kernels/equations/system.h"

namespace kagero {

/// True for systems that define ∂K/∂p_t themselves.
template <class System>
concept DefinesGradientPt = requires(const System& system, const State<double>& s) {
    system.gradient_pt(s);
};

/// Returns true if K depends on p_t.
template <class System>
constexpr bool depends_on_pt() {
    if constexpr (DefinesGradientPt<System>) return true;
    else return energy_residual_program<typename System::Hamiltonian>.uses_any_input(component_pt, state_size);
}

/// Returns ∂K/∂p_t = Ω ∂H/∂p_t, by evaluation of H with dual numbers. The function is not inlined, so that the code
/// that calls it stays small; it is called only where the time is requested.
template <class System, class V>
__attribute__((noinline)) V gradient_pt(const System& system, const State<V>& s) {
    if constexpr (DefinesGradientPt<System>) {
        return system.gradient_pt(s);
    } else {
        using DualNumber = Dual<V, 1>;
        State<DualNumber> dual;
        for (int k = 0; k < state_size; ++k) dual.y[k] = DualNumber(s.y[k]);
        dual.pt() = DualNumber::variable(s.pt(), 0);
        return system.time_rescaling_factor(s) * system.unscaled_energy_residual(dual).derivative[0];
    }
}

}  // namespace kagero

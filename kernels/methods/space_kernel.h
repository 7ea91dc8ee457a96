/// Table of function pointers between the tracing loop and a Hamiltonian. The loop and each Hamiltonian are compiled
/// separately, once per value type.
#pragma once

#include "kernels/autodiff/interpreter.h"
#include "kernels/equations/momentum_line.h"
#include "kernels/integrators/curve.h"
#include "kernels/methods/methods.h"

namespace kagero {

/// Storage that is large enough for any System<H, …>. Packets of parameters take up to 16 times as much as numbers.
struct alignas(64) SystemStorage {
    unsigned char bytes[1 << 17];
};

namespace detail {

/// Returns the system that was constructed in the storage.
template <class System>
const System& system_in(const SystemStorage& storage) {
    static_assert(sizeof(System) <= sizeof(SystemStorage) && alignof(System) <= alignof(SystemStorage));
    return *reinterpret_cast<const System*>(storage.bytes);
}

}  // namespace detail

/// The functions and properties of one Hamiltonian, with or without time rescaling, for one value type.
template <class V>
struct SpaceKernel {
    /// Constructs the system with the given parameters in the storage.
    void (*construct)(SystemStorage&, const double* parameters);
    /// True if H or its derivatives jump where RayState::switching changes sign; steps then end at the sign change.
    bool discontinuous;
    /// True if the derivatives of a formula jump where RayState::switching changes sign (kernels/events/kinks.h).
    bool kinked = false;
    /// True if no step may be longer than RayState::max_step_length.
    bool bounds_steps;
    /// True if H declares a domain: rays end where RayState::domain ≤ 0.
    bool bounded;
    /// True if H declares a region of capture: rays end where RayState::captured ≤ 0.
    bool capturing;
    /// The cyclic coordinates: K does not depend on them.
    Axes cyclic;
    /// Floating-point operations of the programs of H.
    ProgramOperations operations;
    /// For each stepper: nullptr if the stepper supports this Hamiltonian, else the reason why not.
    const char* refusal[kind_count];
    /// Initialises velocity, energy and the memory of the stepper at the start of rays.
    void (*begin[kind_count])(const SystemStorage&, StepperState<V>&, const Coefficients&);
    /// Performs one step from `start` to `end`.
    void (*step[kind_count])(const SystemStorage&, StepperState<V>&, const Coefficients&);
    /// Returns the dense output of a step; nullptr if dense output is the cubic Hermite curve.
    Curve<V> (*curve[kind_count])(const StepperState<V>&, const Coefficients&);
    /// Writes the state and dq/dτ at stage i of a step; nullptr if the stepper stores no stages.
    void (*stage_state[kind_count])(const StepperState<V>&, const Coefficients&, int i, State<V>&, Vec3<V>&);
    /// Integrates rays to the escape sphere; a captured ray stops at its last state outside the region of capture.
    /// nullptr if the stepper has no such function.
    void (*integrate_to_escape[kind_count])(const SystemStorage&, StepperState<V>&, const Coefficients&,
                                            EscapeIntegration<V>&);
    /// `begin` and `step` for scenes in which every ray is straight.
    void (*begin_straight)(const SystemStorage&, StepperState<V>&, const Coefficients&);
    void (*step_straight)(const SystemStorage&, StepperState<V>&, const Coefficients&);
    /// Returns the switching function at a state; nullptr if H declares none.
    V (*switching_function)(const SystemStorage&, const State<V>&);
    /// Returns the part of the change of K in a short step that its derivatives in the step do not explain, relative to
    /// the energy scale of EventFunctions::squared_energy_terms; nullptr except for formulas.
    V (*energy_jump)(const SystemStorage&, const State<V>& start, const State<V>& end, const V& h);
    /// Return the program of ∂K/∂(q, p) as data, and dλ/dτ at a state, for the reverse sweep along rays
    /// (adjoint/sweep.h). Both pointers are nullptr except for packets of double.
    ProgramWithUniforms<double> (*derivatives)(const SystemStorage&);
    V (*time_rescaling_factor)(const SystemStorage&, const State<V>&);
    /// Write ∂K/∂(q, p), and return ∂K/∂p_t, for integrals along rays (trace/path_integrals.h). `time_rate` is nullptr
    /// if H does not depend on p_t.
    void (*gradient)(const SystemStorage&, const State<V>&, V* out);
    V (*time_rate)(const SystemStorage&, const State<V>&);
    /// Returns H and ∂H/∂p along a line in momentum space; nullptr except for packets of double
    /// (interaction/continuations.h).
    MomentumLine<V> (*momentum_line)(const SystemStorage&, const State<V>&, const Vec3<V>& n);
};

/// Returns the kernel of a Hamiltonian. It is defined in one translation unit per Hamiltonian and value type.
/// `rescaled` has an effect only if the Hamiltonian declares a time rescaling.
template <class H, class V>
const SpaceKernel<V>& space_kernel(bool rescaled);

}  // namespace kagero

/// Table of function pointers between the tracing loop and a Hamiltonian. The loop and each Hamiltonian are compiled
/// separately, once per value type.
#pragma once

#include "kernels/autodiff/listing.h"
#include "kernels/integrators/curve.h"
#include "kernels/methods/methods.h"

namespace kagero {

/// Storage that is large enough for any System<H, …>.
struct alignas(64) SystemStorage {
    unsigned char bytes[1 << 14];
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
    /// True if H is not smooth where RayState::switching changes sign; steps then end at the sign change.
    bool discontinuous;
    /// True if no step may be longer than RayState::max_step_length.
    bool bounds_steps;
    /// True if rays end where RayState::domain (`bounded`) or RayState::captured (`capturing`) is not positive.
    bool bounded, capturing;
    /// Cyclic coordinates, which do not occur in K.
    Axes cyclic;
    /// Floating-point operations of the programs of H.
    ProgramOperations operations;
    /// For each stepper: nullptr if it supports this Hamiltonian, else the reason why not.
    const char* refusal[kind_count];
    /// Initialises velocity, energy and the memory of the stepper at the start of rays.
    void (*begin[kind_count])(const SystemStorage&, StepperState<V>&, const Coefficients&);
    /// Performs one step from `start` to `end`.
    void (*step[kind_count])(const SystemStorage&, StepperState<V>&, const Coefficients&);
    /// Returns the dense output of a step; nullptr if it is the cubic Hermite curve.
    Curve<V> (*curve[kind_count])(const StepperState<V>&, const Coefficients&);
    /// Integrates rays to the escape sphere, or captured rays to their last step; nullptr if the stepper has no such
    /// function.
    void (*integrate_to_escape[kind_count])(const SystemStorage&, StepperState<V>&, const Coefficients&,
                                            EscapeIntegration<V>&);
    /// `begin` and `step` for rays that are known to be straight.
    void (*begin_straight)(const SystemStorage&, StepperState<V>&, const Coefficients&);
    void (*step_straight)(const SystemStorage&, StepperState<V>&, const Coefficients&);
    /// Returns the switching function at a state; nullptr if H is smooth.
    V (*switching_function)(const SystemStorage&, const State<V>&);
    /// For the reverse sweep along rays (sweep.h): the program of ∂K/∂(q, p) as data, and dλ/dτ at a state. They exist
    /// only for packets of double.
    ListingWithValues<double> (*derivatives)(const SystemStorage&);
    V (*time_rescaling_factor)(const SystemStorage&, const State<V>&);
};

/// Returns the kernel of a Hamiltonian. It is defined in one translation unit per Hamiltonian and value type.
/// `rescaled` has an effect only if the Hamiltonian declares a time rescaling.
template <class H, class V>
const SpaceKernel<V>& space_kernel(bool rescaled);

}  // namespace kagero

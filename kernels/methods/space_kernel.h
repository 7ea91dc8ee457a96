/// Everything the tracing loop asks of a Hamiltonian, behind function pointers: the loop is compiled once per value
/// type, each Hamiltonian once per value type, and neither knows the other.
#pragma once

#include "kernels/autodiff/listing.h"
#include "kernels/integrators/curve.h"
#include "kernels/methods/methods.h"

namespace kagero {

/// Room for any System<H, …>.
struct alignas(64) SystemStorage {
    unsigned char bytes[1 << 14];
};

namespace detail {

template <class System>
const System& system_in(const SystemStorage& storage) {
    static_assert(sizeof(System) <= sizeof(SystemStorage) && alignof(System) <= alignof(SystemStorage));
    return *reinterpret_cast<const System*>(storage.bytes);
}

}  // namespace detail

/// One Hamiltonian, rescaled or not, on one value type.
template <class V>
struct SpaceKernel {
    /// Puts the system with these parameters into storage.
    void (*construct)(SystemStorage&, const double* parameters);
    /// H is not smooth where RayState::switching changes sign: steps must end there.
    bool discontinuous;
    /// No step may be longer than RayState::max_step_length.
    bool bounds_steps;
    /// Rays end where RayState::domain, or RayState::captured, is not positive.
    bool bounded, capturing;
    /// Coordinates that do not occur in K.
    Axes cyclic;
    ProgramOperations operations;
    /// For each kind of stepper: null if it serves this Hamiltonian, else the reason why not.
    const char* refusal[kind_count];
    /// Fills velocity, energy and the stepper's memory at the start of rays.
    void (*begin[kind_count])(const SystemStorage&, StepperState<V>&, const Coefficients&);
    /// One step from `start` to `end`.
    void (*step[kind_count])(const SystemStorage&, StepperState<V>&, const Coefficients&);
    /// Dense output of that step; null where cubic Hermite is all there is.
    Curve<V> (*curve[kind_count])(const StepperState<V>&, const Coefficients&);
    /// Steps to the escape sphere, or to the last one of a captured ray; null for a stepper that cannot do this.
    void (*integrate_to_escape[kind_count])(const SystemStorage&, StepperState<V>&, const Coefficients&,
                                            EscapeIntegration<V>&);
    /// The first two for rays known to be straight.
    void (*begin_straight)(const SystemStorage&, StepperState<V>&, const Coefficients&);
    void (*step_straight)(const SystemStorage&, StepperState<V>&, const Coefficients&);
    /// The switching function at a state; null where H is smooth.
    V (*switching_function)(const SystemStorage&, const State<V>&);
    /// For the reverse sweep along rays (sweep.h): ∂K/∂(q, p) as data, and at a state dλ/dτ. Packets of double alone
    /// have them.
    Listed<double> (*derivatives)(const SystemStorage&);
    V (*time_rescaling_factor)(const SystemStorage&, const State<V>&);
};

/// Defined in one translation unit per Hamiltonian and value type; `rescaled` only where the Hamiltonian declares it.
template <class H, class V>
const SpaceKernel<V>& space_kernel(bool rescaled);

}  // namespace kagero

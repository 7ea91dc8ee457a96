/// The programs of a formula. A pointer to them is passed in place of the parameters of a Hamiltonian.
#pragma once

#include "kernels/formula/code.h"
#include "kernels/observers/rest_frame.h"
#include "kernels/methods/space_kernel.h"

namespace kagero::formula {

/// The nodes of the program of the gradient, before the conversion to code.
struct Nodes {
    Node nodes[Tape::capacity];
    int outputs[phase_size];
    int size;
};

/// All programs of a formula, and its properties. K is H − H0, or Ω·(H − H0) with time rescaling.
struct Programs {
    Code derivatives, force, velocity;  ///< ∂K/∂(q, p), ∂K/∂q and ∂K/∂p
    Nodes derivative_nodes;             ///< ∂K/∂(q, p) as nodes
    Code energy_residual;               ///< H − H0
    Code time_rescaling_factor;         ///< Ω
    Code event_functions;               ///< struct EventFunctions, and Ω
    Code switching_function;            ///< zero where an operation of H changes its branch
    Code part_force[2], part_velocity[2];  ///< gradients of the parts H_A and H_B
    double level, pt;                   ///< H0 and p_t
    bool separable;                     ///< true if K = ½|p|² + V(q)
    bool parted;                        ///< true if the formula declares H_A and H_B
    bool rescaled;                      ///< true with time rescaling
    bool has_kinks;                     ///< true if H contains a min, max, abs or where
    bool bounds_steps;                  ///< true if the formula or the compiled Hamiltonian declares a step bound
};

/// Returns the programs to which Job::parameters points.
inline const Programs& programs_in(const double* parameters) { return *reinterpret_cast<const Programs*>(parameters); }

/// Functions that record a compiled Hamiltonian on a tape at run time, with its parameters as constants. They serve
/// formulas that declare only a time rescaling factor Ω for a compiled Hamiltonian.
struct RerecordedHamiltonian {
    /// Records H − H0 and returns its node.
    int (*record_energy_residual)(Tape&, const double* parameters);
    /// Records the event functions that the Hamiltonian declares.
    void (*record_events)(Tape&, const double* parameters, const std::array<int, phase_size>& gradient,
                          std::array<int, event_function_count>& event_functions);
    bool bounds_steps;  ///< true if the Hamiltonian declares a step bound
};
/// The functions that record the Hamiltonian H.
template <class H>
inline constexpr RerecordedHamiltonian rerecorded{
    [](Tape& t, const double* parameters) { return record_energy_residual(t, Leaves<H>(t, parameters)); },
    [](Tape& t, const double* parameters, const std::array<int, phase_size>& gradient,
       std::array<int, event_function_count>& event_functions) {
        record_declared_event_functions(t, Leaves<H>(t, parameters), gradient, event_functions);
    },
    BoundsSteps<H>};

/// Differentiates a formula and writes its programs. Returns nullptr, or the reason why the formula cannot be compiled.
/// `compiled` records the compiled Hamiltonian that the formula only rescales; it is nullptr if there is none.
const char* compile(const Formula& formula, const RerecordedHamiltonian* compiled, Programs& programs);

/// Computes the start of a ray at q with the direction d: the momentum p with ∂H/∂p = μ d, μ > 0, and H = H0.
Failure start_along(const Programs& programs, const double (&q)[3], const double (&d)[3], RayStart& out);

/// Computes the inverse metric g^{ab} = ∂²H/∂p_a∂p_b at q. Returns false unless H is that of light in a spacetime:
/// H = ½ g^{ab} p_a p_b with H0 = 0 and p_t > 0.
bool inverse_metric_of(const Programs& programs, const double (&q)[3], Matrix<4>& inverse_metric);

/// Returns the kernel with all steppers for these programs. It is defined in one translation unit per strategy.
template <class V>
const SpaceKernel<V>& space_kernel(const Programs& programs);

}  // namespace kagero::formula

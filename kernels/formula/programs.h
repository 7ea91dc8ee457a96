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

/// A program of K that differentiates it in forward mode: its output is a vector of derivatives of K. Its inputs are
/// the components of the state, and then the unit vectors of the derivatives. It exists only as machine code.
struct ForwardProgram {
    Node nodes[Tape::capacity];
    int size;  ///< 0: there is no such program
    int output;
    CompiledFunction evaluate;  ///< reads the state of one ray, and writes a Packed<double, n>
};
/// The forward programs of a formula, and the components of the state by which each differentiates.
enum ForwardIndex { forward_all, forward_by_position, forward_by_momentum, forward_count };
struct ForwardRange {
    int first, last;
};
inline constexpr ForwardRange forward_ranges[] = {{component_x, phase_size},
                                                  {component_x, component_px},
                                                  {component_px, phase_size}};

/// All programs of a formula, and its properties. K is H − H0, or Ω·(H − H0) with time rescaling.
struct Programs {
    Code derivatives, force, velocity;  ///< ∂K/∂(q, p), ∂K/∂q and ∂K/∂p
    Nodes derivative_nodes;             ///< ∂K/∂(q, p) as nodes
    ForwardProgram forward[forward_count];  ///< only if Formula::for_comparison is set
    Code energy_residual;               ///< H − H0
    Code time_rescaling_factor;         ///< Ω
    Code event_functions;               ///< struct EventFunctions, and Ω
    Code switching_function;            ///< zero where an operation of H changes its branch
    Code part_force[2], part_velocity[2];  ///< gradients of the parts H_A and H_B
    double level, pt;                   ///< H0 and p_t
    int parameters;                     ///< number of parameters
    double parameter[max_formula_parameters];  ///< their values for starts of rays and rest frames
    bool separable;                     ///< true if K = ½|p|² + V(q)
    bool parted;                        ///< true if the formula declares H_A and H_B
    bool rescaled;                      ///< true with time rescaling
    bool has_kinks;                     ///< true if H contains a min, max, abs or where
    bool is_compiled_hamiltonian;       ///< True if H was recorded from a compiled Hamiltonian.
    bool discontinuous;                 ///< True if that Hamiltonian declares a switching function.
    bool bounds_steps;                  ///< True if the formula or the compiled Hamiltonian declares a step bound.
    bool for_comparison;                ///< True if the kernels that exist for comparison can use the programs.
    bool is_compiled;                   ///< True if the programs are machine code.
};

/// Returns the programs to which Job::parameters points.
inline const Programs& programs_in(const double* parameters) { return *reinterpret_cast<const Programs*>(parameters); }

/// Functions that record a compiled Hamiltonian on a tape at run time, with its parameters as constants. They serve
/// formulas that declare only a time rescaling factor Ω for a compiled Hamiltonian, and comparisons.
struct RerecordedHamiltonian {
    /// Records H − H0 and returns its node.
    int (*record_energy_residual)(Tape&, const double* parameters);
    /// Records the event functions that the Hamiltonian declares.
    void (*record_events)(Tape&, const double* parameters, const std::array<int, phase_size>& gradient,
                          std::array<int, event_function_count>& event_functions);
    /// Records the Ω that the Hamiltonian declares and returns its node; nullptr if it declares none.
    int (*record_time_rescaling_factor)(Tape&, const double* parameters);
    bool bounds_steps;   ///< true if the Hamiltonian declares a step bound
    bool discontinuous;  ///< true if the Hamiltonian declares a switching function
};
/// Returns the function RerecordedHamiltonian::record_time_rescaling_factor of H.
template <class H>
constexpr auto recorder_of_time_rescaling_factor() {
    using Recorder = int (*)(Tape&, const double*);
    if constexpr (Rescalable<H>)
        return Recorder{[](Tape& t, const double* parameters) {
            const Leaves<H> leaves(t, parameters);
            return H::rescale(leaves.parameters(), leaves.q).node_on(t);
        }};
    else return Recorder{};
}
/// The functions that record the Hamiltonian H.
template <class H>
inline constexpr RerecordedHamiltonian rerecorded{
    [](Tape& t, const double* parameters) { return record_energy_residual(t, Leaves<H>(t, parameters)); },
    [](Tape& t, const double* parameters, const std::array<int, phase_size>& gradient,
       std::array<int, event_function_count>& event_functions) {
        record_declared_event_functions(t, Leaves<H>(t, parameters), gradient, event_functions);
    },
    recorder_of_time_rescaling_factor<H>(), BoundsSteps<H>, HasDiscontinuity<H>};

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

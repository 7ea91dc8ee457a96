/// What a formula of a scene is compiled to; it travels as the parameters of the Hamiltonian `formula`.
#pragma once

#include "kernels/formula/code.h"
#include "kernels/observers/rest_frame.h"
#include "kernels/methods/space_kernel.h"

namespace kagero::formula {

/// The gradient's program as it was before it became code.
struct Nodes {
    Node nodes[Tape::capacity];
    int outputs[phase_size];
    int size;
};

struct Programs {
    Code derivatives, force, velocity;  ///< of K: H, or Ω·(H − H0)
    Nodes derivative_nodes;
    Code value;                         ///< H − H0
    Code time_rescaling_factor, event_functions;
    Code part_force[2], part_velocity[2];
    double level, pt;
    bool separable, parted, rescaled, bounds_steps;
};

/// As they lie behind Job::parameters.
inline const Programs& programs_in(const double* parameters) { return *reinterpret_cast<const Programs*>(parameters); }

/// A compiled Hamiltonian, to be written down again while the program runs, its parameters as numbers.
struct RerecordedHamiltonian {
    int (*energy)(Tape&, const double* parameters);  ///< H − H0
    void (*ends)(Tape&, const double* parameters, const std::array<int, phase_size>& gradient,
                 std::array<int, event_function_count>& event_functions);
    bool bounds_steps;
};
template <class H>
inline constexpr RerecordedHamiltonian rerecorded{
    [](Tape& t, const double* parameters) { return record_energy(t, Leaves<H>(t, parameters)); },
    [](Tape& t, const double* parameters, const std::array<int, phase_size>& gradient,
       std::array<int, event_function_count>& event_functions) {
        record_ends(t, Leaves<H>(t, parameters), gradient, event_functions);
    },
    BoundsSteps<H>};

/// Differentiates a formula; null, or why that cannot be done. `written` is the compiled Hamiltonian that it but
/// rescales, or null.
const char* compile(const Formula& formula, const RerecordedHamiltonian* written, Programs& programs);

/// p with ∂H/∂p along d in the same sense, and H = H0.
Failure start_along(const Programs& programs, const double (&q)[3], const double (&d)[3], RayStart& out);

/// ∂²H/∂p_a∂p_b, the inverse metric at q, where H is light in a spacetime: ½ G^{ab} p_a p_b with H0 = 0 and p_t > 0.
/// False for any other H.
bool inverse_metric_of(const Programs& programs, const double (&q)[3], Matrix<4>& inverse_metric);

/// Every kind of step on these programs. Defined in one translation unit per strategy.
template <class V>
const SpaceKernel<V>& space_kernel(const Programs& programs);

}  // namespace kagero::formula

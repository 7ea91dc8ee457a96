/// The tape of a Hamiltonian, recorded at compile time, and the straight-line programs that are extracted from it.
///
/// The tape contains K, the gradient of K, and the event functions, which are evaluated at the end of every step. K is
/// H − H0, or Ω·(H − H0) with time rescaling.
#pragma once

#include "kernels/autodiff/program.h"
#include "kernels/autodiff/squares.h"
#include "kernels/equations/state.h"
#include "kernels/numeric/vec.h"

namespace kagero {

// The optional members of a Hamiltonian (hamiltonians/hamiltonian.h), one concept each.

/// H declares the time rescaling factor Ω(q).
template <class H>
concept Rescalable = requires(const typename H::template Parameters<double>& k, const Vec3<double>& q) {
    H::rescale(k, q);
};
/// H declares the domain of a medium.
template <class H>
concept Bounded = requires(const typename H::template Parameters<double>& k, const Vec3<double>& q) {
    H::domain(k, q);
};
/// H declares a function that is ≤ 0 where rays are captured.
template <class H>
concept Capturing = requires(const typename H::template Parameters<double>& k, const Vec3<double>& q) {
    H::captured(k, q, q, q, 1.0);
};
/// H declares a switching function, at whose zeros H or its derivatives jump.
template <class H>
concept HasDiscontinuity = requires(const typename H::template Parameters<double>& k, const Vec3<double>& q) {
    H::switching_function(k, q);
};
/// H declares a step bound.
template <class H>
concept BoundsSteps = requires(const typename H::template Parameters<double>& k, const Vec3<double>& q) {
    H::max_step_length(k, q);
};
/// H declares two parts H_A and H_B, whose sum is H (Satoh 2003, eq. 10).
template <class H>
concept Parted = requires(const typename H::template Parameters<double>& k, const Vec3<double>& q) {
    H::part_a(k, q, q, 1.0);
};
/// H declares the exact flow of H − ½(|p|² − p_t²).
template <class H>
concept ExactlySplit = requires(const typename H::template Parameters<double>& k, Vec3<double>& q) {
    H::remainder_flow(k, q, q, 1.0, 1.0);
};
/// H declares the potential V(u) of the motion in the orbit plane: ½ (du/dφ)² + V(u) is constant, u = 1/r.
template <class H>
concept HasOrbitPlane =
    requires(const typename H::template Parameters<double>& k) { H::orbit_potential(k, 1.0, 1.0); };
/// H declares the difference L dλ/dφ − r² in the orbit plane.
template <class H>
concept HasOrbitDelay = requires(const typename H::template Parameters<double>& k) { H::orbit_delay(k, 1.0); };
/// H declares a throat that leads to a second sheet.
template <class H>
concept TwoSheeted = requires(const typename H::template Parameters<double>& k) { H::throat_radius(k); };
/// H declares for which parameters rays are straight.
template <class H>
concept SometimesStraight = requires(const typename H::template Parameters<double>& k) { H::straight(k); };

/// Returns the parameters as Parameters<S>, from an array in the declared order.
template <class H, class S>
constexpr auto make_parameters(const S* values) {
    return [&]<std::size_t... I>(std::index_sequence<I...>) {
        return typename H::template Parameters<S>{values[I]...};
    }(std::make_index_sequence<H::parameters.size()>{});
}

using StateNodes = std::array<int, state_size>;     ///< Numbers of the nodes of a state on a tape: the inputs of H.
using GradientNodes = std::array<int, phase_size>;  ///< Numbers of the nodes of ∂K/∂(q, p) on a tape.
using VectorNodes = std::array<int, space_size>;    ///< Numbers of the nodes of a vector on a tape.

/// Return the first three nodes (x y z) or the second three (px py pz) as a vector of recorded numbers.
template <std::size_t n>
constexpr Vec3<Recorded> recorded_first_three(Tape& t, const std::array<int, n>& nodes) {
    return {{&t, nodes[component_x]}, {&t, nodes[component_y]}, {&t, nodes[component_z]}};
}
template <std::size_t n>
constexpr Vec3<Recorded> recorded_second_three(Tape& t, const std::array<int, n>& nodes) {
    return {{&t, nodes[component_px]}, {&t, nodes[component_py]}, {&t, nodes[component_pz]}};
}

/// The leaves of a tape: the inputs x y z px py pz pt and the parameters. If `values` is not nullptr, the parameters
/// are recorded as constants with these values.
template <class H>
struct Leaves {
    StateNodes input{};
    Recorded k[H::parameters.size() + 1];
    Vec3<Recorded> q, p;

    constexpr explicit Leaves(Tape& t, const double* values = nullptr) {
        for (int i = 0; i < state_size; ++i) input[i] = t.input(i);
        for (int i = 0; i < static_cast<int>(H::parameters.size()); ++i)
            k[i] = Recorded(&t, values ? t.constant(values[i]) : t.parameter(i));
        q = recorded_first_three(t, input);
        p = recorded_second_three(t, input);
    }
    constexpr auto parameters() const { return make_parameters<H>(k); }
    constexpr Recorded pt(Tape& t) const { return {&t, input[component_pt]}; }
};

/// Records H − H0 and returns its node.
template <class H>
constexpr int record_energy_residual(Tape& t, const Leaves<H>& leaves) {
    return t.sub(H::energy(leaves.parameters(), leaves.q, leaves.p, leaves.pt(t)).node_on(t), t.constant(H::level));
}

/// The leaves of a tape, with the nodes of H − H0 and Ω.
template <class H>
struct Recording : Leaves<H> {
    int energy_residual = -1;  ///< Node of H − H0.
    int rescale = -1;          ///< Node of Ω, or of the constant 1 if H declares no Ω.

    constexpr explicit Recording(Tape& t) : Leaves<H>(t) {
        energy_residual = collect_squares(t, record_energy_residual<H>(t, *this));
        if constexpr (Rescalable<H>) rescale = H::rescale(this->parameters(), this->q).node_on(t);
        else rescale = t.constant(1);
    }
    /// Returns the node of K.
    constexpr int hamiltonian(Tape& t, bool rescaled) const {
        return rescaled ? multiply_through(t, rescale, energy_residual) : energy_residual;
    }
};

/// Records p·∂H/∂p and returns its node.
constexpr int momentum_times_velocity(Tape& t, const StateNodes& input, const GradientNodes& gradient) {
    const auto product = [&](Component k) { return t.mul(input[k], gradient[k]); };
    return t.add(t.add(product(component_px), product(component_py)), product(component_pz));
}

/// The indices of the members of `EventFunctions` in the outputs of their program.
enum EventFunctionIndex {
    index_velocity = 0,
    index_energy_residual = 3,
    index_energy_scale,
    index_squared_energy_terms,
    index_domain,
    index_captured,
    index_switching,
    index_max_step_length,
    event_function_count
};

/// Records the event functions and returns their nodes. `hamiltonian` is the node of K; `rescaling` is the node of Ω,
/// or of the constant 1 without time rescaling. The optional functions are the constant 1 until
/// `record_declared_event_functions` replaces them.
constexpr std::array<int, event_function_count> record_event_functions(Tape& t, const StateNodes& input,
                                                                       int hamiltonian, int rescaling, double level,
                                                                       const GradientNodes& gradient) {
    const auto norm2 = [&t](int a, int b, int c) { return t.add(t.add(t.mul(a, a), t.mul(b, b)), t.mul(c, c)); };
    const auto magnitude = [&t](int a) { return t.binary(Op::max, a, t.neg(a)); };
    const int p_velocity = momentum_times_velocity(t, input, gradient),
              rescaled_level = t.mul(rescaling, t.constant(level)), one = t.constant(1);
    const int squares = t.mul(norm2(input[component_px], input[component_py], input[component_pz]),
                              norm2(gradient[component_px], gradient[component_py], gradient[component_pz]));
    return {gradient[component_px], gradient[component_py], gradient[component_pz], hamiltonian,
            t.add(magnitude(p_velocity), magnitude(rescaled_level)),
            t.add(squares, t.mul(rescaled_level, rescaled_level)), one, one, one, one};
}

/// Records the optional event functions that H declares. `gradient` contains the nodes of ∂K/∂(q, p).
template <class H>
constexpr void record_declared_event_functions(Tape& t, const Leaves<H>& leaves, const GradientNodes& gradient,
                                               std::array<int, event_function_count>& event_functions) {
    const Vec3<Recorded> velocity = recorded_second_three(t, gradient);
    if constexpr (Bounded<H>) event_functions[index_domain] = H::domain(leaves.parameters(), leaves.q).node_on(t);
    if constexpr (Capturing<H>)
        event_functions[index_captured] =
            H::captured(leaves.parameters(), leaves.q, leaves.p, velocity, leaves.pt(t)).node_on(t);
    if constexpr (HasDiscontinuity<H>)
        event_functions[index_switching] = H::switching_function(leaves.parameters(), leaves.q).node_on(t);
    if constexpr (BoundsSteps<H>)
        event_functions[index_max_step_length] = H::max_step_length(leaves.parameters(), leaves.q).node_on(t);
}

/// Records the gradient of K by x y z px py pz and returns its nodes. `hamiltonian` is the node of K.
constexpr GradientNodes record_derivatives(Tape& t, int hamiltonian, const StateNodes& input) {
    GradientNodes leaves{}, gradient{};
    for (int i = 0; i < phase_size; ++i) leaves[i] = input[i];
    record_gradient<phase_size>(t, hamiltonian, leaves, gradient);
    return gradient;
}

/// The inputs that vary while the implicit half steps of Satoh (2003), eq. (9), are solved: the momentum in a kick, and
/// the position in a drift.
inline constexpr VaryingInputs kick_varies{component_px, phase_size}, drift_varies{component_x, space_size};

/// The tape from which all programs of a Hamiltonian are extracted, with the nodes of their outputs. It is recorded at
/// compile time.
template <class H, bool Rescaled>
struct HamiltonianTape {
    Tape tape{};
    GradientNodes gradient{};                    ///< ∂K/∂(x y z px py pz).
    std::array<int, 1> energy_residual{};        ///< H − H0; not set if `Rescaled` is true.
    std::array<int, 1> time_rescaling_factor{};  ///< Ω.
    std::array<int, event_function_count> event_functions{};

    constexpr HamiltonianTape() {
        Tape& t = tape;
        const Recording<H> recording(t);
        const int hamiltonian = recording.hamiltonian(t, Rescaled);
        gradient = record_derivatives(t, hamiltonian, recording.input);
        time_rescaling_factor = {recording.rescale};
        const int rescaling = Rescaled ? recording.rescale : t.constant(1);
        event_functions = record_event_functions(t, recording.input, hamiltonian, rescaling, H::level, gradient);
        if constexpr (!Rescaled) energy_residual = {recording.energy_residual};
        record_declared_event_functions<H>(t, recording, gradient, event_functions);
    }
    /// Returns the nodes of ∂K/∂q if `first` is component_x, or of ∂K/∂p if `first` is component_px.
    constexpr VectorNodes gradient_by(Component first) const {
        return {gradient[first], gradient[first + 1], gradient[first + 2]};
    }
};
template <class H, bool Rescaled>
inline constexpr HamiltonianTape<H, Rescaled> hamiltonian_tape{};

// The programs of a Hamiltonian.
template <class H, bool Rescaled>
inline constexpr auto derivatives_program =
    extract<hamiltonian_tape<H, Rescaled>, hamiltonian_tape<H, Rescaled>.gradient>();
template <class H, bool Rescaled>
inline constexpr auto force_program =
    extract<hamiltonian_tape<H, Rescaled>, hamiltonian_tape<H, Rescaled>.gradient_by(component_x), kick_varies>();
template <class H, bool Rescaled>
inline constexpr auto velocity_program =
    extract<hamiltonian_tape<H, Rescaled>, hamiltonian_tape<H, Rescaled>.gradient_by(component_px), drift_varies>();
template <class H>
inline constexpr auto energy_residual_program =
    extract<hamiltonian_tape<H, false>, hamiltonian_tape<H, false>.energy_residual>();
template <class H>
inline constexpr auto rescale_program =
    extract<hamiltonian_tape<H, false>, hamiltonian_tape<H, false>.time_rescaling_factor>();
template <class H, bool Rescaled>
inline constexpr auto event_functions_program =
    extract<hamiltonian_tape<H, Rescaled>, hamiltonian_tape<H, Rescaled>.event_functions>();

/// The part H_A of a Hamiltonian, or H_B if `is_b` is true, as a Hamiltonian of its own.
template <class H, bool is_b>
struct Part {
    static constexpr const auto& parameters = H::parameters;
    static constexpr double level = 0;
    template <class V>
    using Parameters = typename H::template Parameters<V>;
    template <class V>
    static constexpr V energy(const Parameters<V>& k, const Vec3<V>& q, const Vec3<V>& p, const V& pt) {
        if constexpr (is_b) return H::part_b(k, q, p, pt);
        else return H::part_a(k, q, p, pt);
    }
};

/// True if Newton's method solves every implicit step: for the parts H_A and H_B, which only the recipe as printed
/// uses. For other Hamiltonians, Newton's method solves only steps for which fixed-point iteration does not converge.
template <class H>
inline constexpr bool solved_only_by_newton = false;
template <class H, bool is_b>
inline constexpr bool solved_only_by_newton<Part<H, is_b>> = true;

}  // namespace kagero

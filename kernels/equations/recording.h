/// What the compiler records of a Hamiltonian: one tape with K, its gradient and what the tracing loop asks of every
/// step's end, and the straight-line programs that are cut from it.
#pragma once

#include "kernels/autodiff/program.h"
#include "kernels/autodiff/squares.h"
#include "kernels/equations/state.h"
#include "kernels/numeric/vec.h"

namespace kagero {

template <class H>
concept Rescalable = requires(const typename H::template Parameters<double>& k, const Vec3<double>& q) {
    H::rescale(k, q);
};
template <class H>
concept Bounded = requires(const typename H::template Parameters<double>& k, const Vec3<double>& q) {
    H::domain(k, q);
};
template <class H>
concept Capturing = requires(const typename H::template Parameters<double>& k, const Vec3<double>& q) {
    H::captured(k, q, q, q, 1.0);
};
/// H is not smooth where `surface` is zero.
template <class H>
concept HasDiscontinuity = requires(const typename H::template Parameters<double>& k, const Vec3<double>& q) {
    H::switching_function(k, q);
};
/// Bounds the length of steps.
template <class H>
concept BoundsSteps = requires(const typename H::template Parameters<double>& k, const Vec3<double>& q) {
    H::max_step_length(k, q);
};
/// States H as a sum of two parts, the paper's H_A and H_B (eq. 10).
template <class H>
concept Parted = requires(const typename H::template Parameters<double>& k, const Vec3<double>& q) {
    H::part_a(k, q, q, 1.0);
};
/// States the exact flow of H − ½(|p|² − p_t²).
template <class H>
concept ExactlySplit = requires(const typename H::template Parameters<double>& k, Vec3<double>& q) {
    H::remainder_flow(k, q, q, 1.0, 1.0);
};
/// States V(u) of the motion in the plane of an orbit, ½ (du/dφ)² + V(u) with u = 1/r.
template <class H>
concept Orbiting =
    requires(const typename H::template Parameters<double>& k) { H::orbit_potential(k, 1.0, 1.0); };
template <class H>
concept Delaying = requires(const typename H::template Parameters<double>& k) { H::orbit_delay(k, 1.0); };
/// Joins a second universe to this one.
template <class H>
concept TwoSheeted = requires(const typename H::template Parameters<double>& k) { H::throat_radius(k); };
template <class H>
concept SometimesStraight = requires(const typename H::template Parameters<double>& k) { H::straight(k); };

/// Parameters<S> filled from an array in declared order.
template <class H, class S>
constexpr auto make_parameters(const S* values) {
    return [&]<std::size_t... I>(std::index_sequence<I...>) {
        return typename H::template Parameters<S>{values[I]...};
    }(std::make_index_sequence<H::parameters.size()>{});
}

/// The nodes of a tape that hold a state, and those that hold the gradient of H by its phase.
using StateNodes = std::array<int, state_size>;
using GradientNodes = std::array<int, phase_size>;
using VectorNodes = std::array<int, space_size>;

/// The nodes of positions, or of velocities, and those of momenta.
template <std::size_t n>
constexpr Vec3<Recorded> recorded_first(Tape& t, const std::array<int, n>& nodes) {
    return {{&t, nodes[component_x]}, {&t, nodes[component_y]}, {&t, nodes[component_z]}};
}
template <std::size_t n>
constexpr Vec3<Recorded> recorded_second(Tape& t, const std::array<int, n>& nodes) {
    return {{&t, nodes[component_px]}, {&t, nodes[component_py]}, {&t, nodes[component_pz]}};
}

/// The leaves of a tape: x y z px py pz pt, and the parameters, which are numbers where they are given.
template <class H>
struct Leaves {
    StateNodes input{};
    Recorded k[H::parameters.size() + 1];
    Vec3<Recorded> q, p;

    constexpr explicit Leaves(Tape& t, const double* numbers = nullptr) {
        for (int i = 0; i < state_size; ++i) input[i] = t.input(i);
        for (int i = 0; i < static_cast<int>(H::parameters.size()); ++i)
            k[i] = Recorded(&t, numbers ? t.constant(numbers[i]) : t.parameter(i));
        q = recorded_first(t, input), p = recorded_second(t, input);
    }
    constexpr auto parameters() const { return make_parameters<H>(k); }
    constexpr Recorded pt(Tape& t) const { return {&t, input[component_pt]}; }
};

/// H − H0.
template <class H>
constexpr int record_energy(Tape& t, const Leaves<H>& x) {
    return t.sub(H::energy(x.parameters(), x.q, x.p, x.pt(t)).on(t), t.constant(H::level));
}

/// The leaves and the Hamiltonian of a tape.
template <class H>
struct Recording : Leaves<H> {
    int energy = -1;   ///< H − H0
    int rescale = -1;  ///< Ω, or the constant 1

    constexpr explicit Recording(Tape& t) : Leaves<H>(t) {
        energy = take_squares_together(t, record_energy<H>(t, *this));
        if constexpr (Rescalable<H>) rescale = H::rescale(this->parameters(), this->q).on(t);
        else rescale = t.constant(1);
    }
    /// H − H0, or K.
    constexpr int hamiltonian(Tape& t, bool rescaled) const {
        return rescaled ? multiply_through(t, rescale, energy) : energy;
    }
};

/// p·∂H/∂p from the leaves and the gradient of a tape.
constexpr int momentum_times_velocity(Tape& t, const StateNodes& input, const GradientNodes& gradient) {
    const auto product = [&](Component k) { return t.mul(input[k], gradient[k]); };
    return t.add(t.add(product(component_px), product(component_py)), product(component_pz));
}

/// Where the numbers of `EventFunctions` are among the outputs of their program.
enum EventFunctionIndex { index_velocity = 0, index_excess = 3, index_size, index_terms, index_domain, index_captured, index_switching, index_max_step_length, event_function_count };

/// The nodes of a event_functions on a tape; of what a Hamiltonian does not state, the number 1.
constexpr std::array<int, event_function_count> record_event_functions(Tape& t, const StateNodes& input,
                                                                       int hamiltonian, int rescaling, double level,
                                                                       const GradientNodes& gradient) {
    const auto square = [&t](int a, int b, int c) { return t.add(t.add(t.mul(a, a), t.mul(b, b)), t.mul(c, c)); };
    const auto size = [&t](int a) { return t.binary(Op::max, a, t.neg(a)); };
    const int moving = momentum_times_velocity(t, input, gradient), resting = t.mul(rescaling, t.constant(level)),
              one = t.constant(1);
    const int squares = t.mul(square(input[component_px], input[component_py], input[component_pz]),
                              square(gradient[component_px], gradient[component_py], gradient[component_pz]));
    return {gradient[component_px], gradient[component_py], gradient[component_pz], hamiltonian,
            t.add(size(moving), size(resting)), t.add(squares, t.mul(resting, resting)), one, one, one, one};
}

/// … and what a Hamiltonian states of the ends of steps.
template <class H>
constexpr void record_ends(Tape& t, const Leaves<H>& x, const GradientNodes& gradient,
                           std::array<int, event_function_count>& event_functions) {
    const Vec3<Recorded> velocity = recorded_second(t, gradient);
    if constexpr (Bounded<H>) event_functions[index_domain] = H::domain(x.parameters(), x.q).on(t);
    if constexpr (Capturing<H>)
        event_functions[index_captured] = H::captured(x.parameters(), x.q, x.p, velocity, x.pt(t)).on(t);
    if constexpr (HasDiscontinuity<H>)
        event_functions[index_switching] = H::switching_function(x.parameters(), x.q).on(t);
    if constexpr (BoundsSteps<H>)
        event_functions[index_max_step_length] = H::max_step_length(x.parameters(), x.q).on(t);
}

/// The gradient by x y z px py pz.
constexpr GradientNodes record_derivatives(Tape& t, int hamiltonian, const StateNodes& input) {
    GradientNodes wanted{}, gradient{};
    for (int i = 0; i < phase_size; ++i) wanted[i] = input[i];
    record_gradient<phase_size>(t, hamiltonian, wanted, gradient);
    return gradient;
}

/// What stays and what varies while the implicit halves of eq. (9) are solved.
inline constexpr Varying kick_varies{component_px, phase_size}, drift_varies{component_x, space_size};

/// Everything the programs of a Hamiltonian are cut from: one tape, recorded once by the compiler.
template <class H, bool Rescaled>
struct HamiltonianTape {
    Tape tape{};
    GradientNodes gradient{};     ///< ∂K/∂(x y z px py pz)
    std::array<int, 1> energy{};  ///< H − H0; filled in only where not Rescaled
    std::array<int, 1> time_rescaling_factor{};    ///< Ω
    std::array<int, event_function_count> event_functions{};

    constexpr HamiltonianTape() {
        Tape& t = tape;
        const Recording<H> r(t);
        const int k = r.hamiltonian(t, Rescaled);
        gradient = record_derivatives(t, k, r.input);
        time_rescaling_factor = {r.rescale};
        event_functions =
            record_event_functions(t, r.input, k, Rescaled ? r.rescale : t.constant(1), H::level, gradient);
        if constexpr (!Rescaled) energy = {r.energy};
        record_ends<H>(t, r, gradient, event_functions);
    }
    constexpr VectorNodes side(Component from) const {
        return {gradient[from], gradient[from + 1], gradient[from + 2]};
    }
};
template <class H, bool Rescaled>
inline constexpr HamiltonianTape<H, Rescaled> hamiltonian_tape{};

/// The programs.
template <class H, bool Rescaled>
inline constexpr auto derivatives_program =
    extract<hamiltonian_tape<H, Rescaled>, hamiltonian_tape<H, Rescaled>.gradient>();
template <class H, bool Rescaled>
inline constexpr auto force_program =
    extract<hamiltonian_tape<H, Rescaled>, hamiltonian_tape<H, Rescaled>.side(component_x), kick_varies>();
template <class H, bool Rescaled>
inline constexpr auto velocity_program =
    extract<hamiltonian_tape<H, Rescaled>, hamiltonian_tape<H, Rescaled>.side(component_px), drift_varies>();
template <class H>
inline constexpr auto energy_program = extract<hamiltonian_tape<H, false>, hamiltonian_tape<H, false>.energy>();
template <class H>
inline constexpr auto rescale_program =
    extract<hamiltonian_tape<H, false>, hamiltonian_tape<H, false>.time_rescaling_factor>();
template <class H, bool Rescaled>
inline constexpr auto event_functions_program =
    extract<hamiltonian_tape<H, Rescaled>, hamiltonian_tape<H, Rescaled>.event_functions>();

/// One part of a Hamiltonian as a Hamiltonian of its own.
template <class H, bool second>
struct Part {
    static constexpr const auto& parameters = H::parameters;
    static constexpr double level = 0;
    template <class V>
    using Parameters = typename H::template Parameters<V>;
    template <class V>
    static constexpr V energy(const Parameters<V>& k, const Vec3<V>& q, const Vec3<V>& p, const V& pt) {
        if constexpr (second) return H::part_b(k, q, p, pt);
        else return H::part_a(k, q, p, pt);
    }
};

/// Whether Newton's method takes every step, as in the printed recipe, and not only those that iteration leaves.
template <class H>
inline constexpr bool stepped_by_newton = false;
template <class H, bool second>
inline constexpr bool stepped_by_newton<Part<H, second>> = true;

}  // namespace kagero

/// Hamilton's equations of a scalar H: dq/dλ = ∂H/∂p, dp/dλ = −∂H/∂q (Satoh 2003, eq. 7). The derivatives are programs
/// that are extracted from the tape of H.
///
/// `System<H, Rescaled, S>` contains the parameters of a Hamiltonian as numbers of type S. It evaluates the programs of
/// K on any value type with lanes of type S. If S is a packet, each lane has its own parameters, and the programs are
/// evaluated on this packet type. K is H − H0, or Ω(q)·(H − H0) if `Rescaled` is true. On H = H0 the
/// rescaled K has the same rays with another parameter τ, where dλ = Ω dτ (Poincaré's time transformation; Hairer,
/// Lubich & Wanner 2006, §VIII.2). Without rescaling, τ = λ.
#pragma once

#include "kernels/autodiff/dual.h"
#include "kernels/autodiff/interpreter.h"
#include "kernels/autodiff/operations.h"
#include "kernels/equations/recording.h"
#include "kernels/equations/state.h"
#include "kernels/equations/uniforms.h"

namespace kagero {

/// The functions that are evaluated at the end of every step, to detect events and to measure the energy error.
template <class V>
struct EventFunctions {
    Vec3<V> velocity;        ///< ∂K/∂p.
    V energy_residual;       ///< K, which is 0 on an exact ray.
    V energy_scale;          ///< |p·∂K/∂p| + |Ω H0|, the denominator of the energy error.
    V squared_energy_terms;  ///< |p|²|∂K/∂p|² + (Ω H0)², a squared energy scale that is positive for every ray.
    V domain;                ///< ≤ 0 outside the domain of the medium.
    V captured;              ///< ≤ 0 where the ray is captured.
    V switching;             ///< Changes sign at a discontinuity of H or its derivatives.
    V max_step_length;       ///< Step bound at this position.
};

/// Returns the event functions from the outputs of their program.
template <class V>
KAGERO_INLINE EventFunctions<V> event_functions_of(const V* out) {
    return {{out[index_velocity], out[index_velocity + 1], out[index_velocity + 2]},
            out[index_energy_residual],
            out[index_energy_scale],
            out[index_squared_energy_terms],
            out[index_domain],
            out[index_captured],
            out[index_switching],
            out[index_max_step_length]};
}

/// A subset of the three coordinate axes.
struct Axes {
    bool x = false, y = false, z = false;
    constexpr bool any() const { return x || y || z; }
};

/// Returns true if K = ½|p|² + V(q), as Nyström methods require: the force does not depend on p, and the velocity is p.
template <class Force, class Velocity>
constexpr bool is_separable(const Force& force, const Velocity& velocity) {
    bool is_momentum = true;
    for (int k = 0; k < space_size; ++k) is_momentum = is_momentum && velocity.returns_input(k, momentum(k));
    return is_momentum && !force.uses_any_input(component_px, component_pt);
}

/// Returns the number of carried quantities of a system. A system that carries more than λ declares
///
///     static constexpr int carried = N;                                 // the number, including λ
///     static constexpr bool carried_rates_need_p = B;                   // B is true if a rate depends on p
///     template <class V> void carried_rates(const State<V>&, V* rates)  // d/dτ of all except λ
template <class System>
constexpr int carried_in() {
    if constexpr (requires { System::carried; }) return System::carried;
    else return 1;
}
/// Returns nullptr if the system carries only λ, else the reason why a stepper that integrates no rates of carried
/// quantities cannot support the system.
template <class System>
constexpr const char* refusal_to_carry() {
    if (carried_in<System>() == 1) return nullptr;
    return "the method cannot integrate carried quantities other than the ray parameter";
}

/// The right-hand sides of Hamilton's equations, ∂K/∂q and ∂K/∂p, as separate programs for semi-implicit steps.
template <class H, bool Rescaled, class S>
class RightHandSides {
    static constexpr const auto& force_ = force_program<H, Rescaled>;
    static constexpr const auto& velocity_ = velocity_program<H, Rescaled>;

public:
    /// True if ∂K/∂q depends on p; otherwise the kick of Satoh (2003), eq. (9), is explicit.
    static constexpr bool force_needs_p = force_.uses_any_input(component_px, component_pt);
    /// True if ∂K/∂p depends on q; otherwise the drift of the adjoint of eq. (9) is explicit.
    static constexpr bool velocity_needs_q = velocity_.uses_any_input(component_x, component_px);
    static constexpr bool separable = is_separable(force_, velocity_);
    /// The cyclic coordinates: K does not depend on them, so that their momenta are constant along a ray.
    static constexpr Axes cyclic = [] {
        const auto is_cyclic = [](int k) {
            return force_.returns_zero(k) && !rescale_program<H>.uses_any_input(k, k + 1);
        };
        return Axes{is_cyclic(component_x), is_cyclic(component_y), is_cyclic(component_z)};
    }();

    explicit RightHandSides(const double* parameters) : force_uniforms_(parameters), velocity_uniforms_(parameters) {}

    /// Returns ∂K/∂q.
    template <class V>
    KAGERO_INLINE Vec3<V> gradient_q(const State<V>& s) const {
        return evaluate_vector<force_>(force_uniforms_.values, s);
    }
    /// Returns ∂K/∂p = dq/dτ.
    template <class V>
    KAGERO_INLINE Vec3<V> gradient_p(const State<V>& s) const {
        return evaluate_vector<velocity_>(velocity_uniforms_.values, s);
    }
    /// Writes ∂²K/∂q_i∂p_j (9 numbers, row by row). The program of ∂K/∂q is evaluated with dual numbers: once if it is
    /// short and every step needs the derivatives, else once per component of p.
    template <class V>
    __attribute__((noinline)) void mixed(const State<V>& s, V* out) const {
        constexpr bool all_at_once = solved_only_by_newton<H> && force_.length() <= max_inlined_length;
        constexpr int per_evaluation = all_at_once ? space_size : 1;
        using DualNumber = Dual<V, per_evaluation>;
        for (int first = 0; first < space_size; first += per_evaluation) {
            DualNumber in[state_size], force[space_size];
            for (int k = 0; k < state_size; ++k) in[k] = DualNumber(s.y[k]);
            for (int k = 0; k < per_evaluation; ++k)
                in[momentum(first + k)] = DualNumber::variable(s.y[momentum(first + k)], k);
            run<force_>(force_uniforms_.values, in, force);
            for (int i = 0; i < space_size; ++i)
                for (int k = 0; k < per_evaluation; ++k) out[space_size * i + first + k] = force[i].derivative[k];
        }
    }

protected:
    /// Greatest length of a program that is inlined in several steppers.
    static constexpr int max_inlined_length = 100;
    /// Evaluates a program. Its code is inlined, unless K is separable and the program is long: several steppers use
    /// the programs of a separable K. Other long programs are used only by the functions of called_system.h.
    template <const auto& P, class V>
    KAGERO_INLINE static void evaluate(const S* uniforms, const V* inputs, V* outputs) {
        if constexpr (separable && P.length() > max_inlined_length) run_without_inlining<P>(uniforms, inputs, outputs);
        else run<P>(uniforms, inputs, outputs);
    }
    /// Writes ∂K/∂q to out[0], out[1] and out[2].
    template <class V>
    KAGERO_INLINE void write_gradient_q(const State<V>& s, V* out) const {
        evaluate<force_>(force_uniforms_.values, s.y, out);
    }

private:
    template <const auto& P, class V>
    __attribute__((noinline)) static void run_without_inlining(const S* uniforms, const V* inputs, V* outputs) {
        run<P>(uniforms, inputs, outputs);
    }
    template <const auto& P, class V>
    KAGERO_INLINE static Vec3<V> evaluate_vector(const S* uniforms, const State<V>& s) {
        V out[space_size];
        evaluate<P>(uniforms, s.y, out);
        return {out[0], out[1], out[2]};
    }

    Uniforms<force_program<H, Rescaled>, S> force_uniforms_;
    Uniforms<velocity_program<H, Rescaled>, S> velocity_uniforms_;
};

/// The right-hand sides of the parts H_A and H_B, for the recipe as printed (kernels/recipe).
template <class H, class S>
struct PartSystems {
    RightHandSides<Part<H, false>, false, S> a;
    RightHandSides<Part<H, true>, false, S> b;
    explicit PartSystems(const double* parameters) : a(parameters), b(parameters) {}
};
/// Replaces `PartSystems` where there are no parts.
struct NoParts {
    explicit NoParts(const double*) {}
};

/// The Hamiltonian ½ (du/dφ)² + V(u) of the motion in the orbit plane, where u = 1/r, φ is the polar angle in the plane
/// and b is the impact parameter. u = q.x, du/dφ = p.x, g = 1/b² = p.y. V is differentiated like any Hamiltonian.
template <class H>
struct OrbitPlane {
    static constexpr const auto& parameters = H::parameters;
    static constexpr double level = 0;
    template <class V>
    using Parameters = typename H::template Parameters<V>;
    template <class V>
    static constexpr V energy(const Parameters<V>& k, const Vec3<V>& q, const Vec3<V>& p, const V&) {
        return 0.5 * p.x * p.x + H::orbit_potential(k, q.x, p.y);
    }
};
/// Evaluates the potential V(u) of the motion in the orbit plane, for a given g = 1/b².
template <class H, class S>
class OrbitSystem : public RightHandSides<OrbitPlane<H>, false, S> {
public:
    explicit OrbitSystem(const double* parameters)
        : RightHandSides<OrbitPlane<H>, false, S>(parameters), potential_uniforms_(parameters) {}
    /// Returns ∂V/∂u.
    template <class V>
    KAGERO_INLINE V slope(const V& u, const V& g) const { return this->gradient_q(at_rest(u, g)).x; }
    template <class V>
    KAGERO_INLINE V potential(const V& u, const V& g) const {
        V out[1];
        run<energy_residual_program<OrbitPlane<H>>>(potential_uniforms_.values, at_rest(u, g).y, out);
        return out[0];
    }

private:
    /// Returns the state of OrbitPlane with du/dφ = 0.
    template <class V>
    KAGERO_INLINE static State<V> at_rest(const V& u, const V& g) {
        const V zero(S(0));
        return {{u, zero, zero, zero, g, zero, zero}};
    }
    Uniforms<energy_residual_program<OrbitPlane<H>>, S> potential_uniforms_;
};
/// Replaces `OrbitSystem` where there is no orbit potential.
struct NoOrbit {
    explicit NoOrbit(const double*) {}
};

/// Hamilton's equations of K, the event functions, and the parts and orbit potential that H declares.
template <class H, bool Rescaled, class S>
class System : public RightHandSides<H, Rescaled, S> {
    static_assert(!Rescaled || Rescalable<H>);
    using Base = RightHandSides<H, Rescaled, S>;
    static constexpr const auto& derivatives_ = derivatives_program<H, Rescaled>;
    static constexpr const auto& event_functions_ = event_functions_program<H, Rescaled>;

public:
    using Hamiltonian = H;
    static constexpr bool rescaled = Rescaled;
    /// True if steppers use this system as a called system (see is_called).
    static constexpr bool called = Rescaled != Rescalable<H> || derivatives_.length() > Base::max_inlined_length;
    /// True if H declares `domain`, `captured`, `switching_function` or `max_step_length`, respectively. The event
    /// function is the constant 1 otherwise.
    static constexpr bool bounded = Bounded<H>, capturing = Capturing<H>, discontinuous = HasDiscontinuity<H>,
                          bounds_steps = BoundsSteps<H>;

    static constexpr ProgramOperations operations = [] {
        ProgramOperations o{flops_of(derivatives_), flops_of(force_program<H, Rescaled>),
                            flops_of(velocity_program<H, Rescaled>), flops_of(event_functions_)};
        if constexpr (HasOrbitPlane<H>) o.potential_slope = flops_of(force_program<OrbitPlane<H>, false>);
        return o;
    }();

    explicit System(const double* parameters)
        : Base(parameters), parameters_(parameters), parts_(parameters), orbit_(parameters),
          derivatives_uniforms_(parameters), energy_residual_uniforms_(parameters), rescale_uniforms_(parameters),
          event_functions_uniforms_(parameters) {}
    static constexpr S level() { return S(H::level); }
    const auto& part_a() const requires Parted<H> { return parts_.a; }
    const auto& part_b() const requires Parted<H> { return parts_.b; }
    const auto& orbit() const requires HasOrbitPlane<H> { return orbit_; }

    /// Writes ∂K/∂(q, p), a `PhaseGradient`.
    template <class V>
    KAGERO_INLINE void derivatives(const State<V>& s, V* out) const {
        if constexpr (Base::separable) {
            out[component_px] = s.y[component_px];
            out[component_py] = s.y[component_py];
            out[component_pz] = s.y[component_pz];
            Base::write_gradient_q(s, out);
        } else {
            Base::template evaluate<derivatives_>(derivatives_uniforms_.values, s.y, out);
        }
    }
    /// Writes ∂²K/∂(q, p)², a `Hessian`, by evaluation of the gradient with dual numbers, one variable at a time.
    template <class V>
    __attribute__((noinline)) void hessian(const State<V>& s, V* out) const {
        using DualNumber = Dual<V, 1>;
        for (int variable = 0; variable < phase_size; ++variable) {
            DualNumber in[state_size], g[phase_size];
            for (int k = 0; k < state_size; ++k) in[k] = DualNumber(s.y[k]);
            in[variable] = DualNumber::variable(s.y[variable], 0);
            run<derivatives_>(derivatives_uniforms_.values, in, g);
            for (int k = 0; k < phase_size; ++k) out[hessian_index(k, variable)] = g[k].derivative[0];
        }
    }
    /// Returns the program of `derivatives` as data.
    ProgramWithUniforms<S> derivatives_with_uniforms() const {
        return {{derivatives_.nodes, derivatives_.slot, derivatives_.outputs.data(), derivatives_.size},
                derivatives_uniforms_.values};
    }
    /// Returns the parameters of H.
    template <class V>
    KAGERO_INLINE auto parameters() const {
        V k[H::parameters.size() + 1];
        for (std::size_t i = 0; i < H::parameters.size(); ++i) k[i] = V(parameters_.k[i]);
        return make_parameters<H>(k);
    }
    /// Returns H − H0, without the factor Ω.
    template <class V>
    KAGERO_INLINE V unscaled_energy_residual(const State<V>& s) const {
        V out[1];
        run<energy_residual_program<H>>(energy_residual_uniforms_.values, s.y, out);
        return out[0];
    }
    /// Returns the event functions at s.
    template <class V>
    KAGERO_INLINE EventFunctions<V> event_functions(const State<V>& s) const {
        V out[event_function_count];
        run<event_functions_>(event_functions_uniforms_.values, s.y, out);
        return event_functions_of(out);
    }
    /// Returns dλ/dτ = Ω at the position of s; 1 without rescaling.
    template <class V>
    KAGERO_INLINE V time_rescaling_factor(const State<V>& s) const {
        V out[1] = {V(S(1))};
        if constexpr (Rescaled) run<rescale_program<H>>(rescale_uniforms_.values, s.y, out);
        return out[0];
    }

private:
    /// The parameters as numbers of type S. The array has an extra element because H may have no parameters.
    struct ParameterValues {
        S k[H::parameters.size() + 1] = {};
        explicit ParameterValues(const double* parameters) {
            for (int i = 0; i < int(H::parameters.size()); ++i) k[i] = parameter_of<S>(parameters, i);
        }
    };
    /// True if each lane has its own parameters. The steppers that use parts or the orbit plane do not support this.
    static constexpr bool is_packet = lane_count<S> > 1;
    /// `parts` and `orbit_plane` return the types of parts_ and orbit_, wrapped in std::type_identity.
    template <class Self>
    static constexpr auto parts() {
        if constexpr (Parted<Self> && !Rescaled && !is_packet) return std::type_identity<PartSystems<Self, S>>{};
        else return std::type_identity<NoParts>{};
    }
    template <class Self>
    static constexpr auto orbit_plane() {
        if constexpr (HasOrbitPlane<Self> && !Rescaled && !is_packet)
            return std::type_identity<OrbitSystem<Self, S>>{};
        else return std::type_identity<NoOrbit>{};
    }

    ParameterValues parameters_;
    [[no_unique_address]] typename decltype(parts<H>())::type parts_;
    [[no_unique_address]] typename decltype(orbit_plane<H>())::type orbit_;
    Uniforms<derivatives_program<H, Rescaled>, S> derivatives_uniforms_;
    Uniforms<energy_residual_program<H>, S> energy_residual_uniforms_;
    Uniforms<rescale_program<H>, S> rescale_uniforms_;
    Uniforms<event_functions_program<H, Rescaled>, S> event_functions_uniforms_;
};

}  // namespace kagero

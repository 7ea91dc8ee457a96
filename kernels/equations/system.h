/// From a scalar H to Hamilton's equations: dq/dλ = ∂H/∂p, dp/dλ = −∂H/∂q (Satoh 2003, eq. 7), by the tape.
///
/// `System<H, Rescaled, S>` holds a Hamiltonian's parameters as numbers of type S and runs its derivative programs on
/// any value type whose lanes are S. With `Rescaled` it is K = Ω(q)·(H − H0) multiplied through, which has the same
/// rays on H = H0 in another parameter τ, dλ = Ω dτ (Poincaré's time transformation; Hairer, Lubich & Wanner 2006,
/// §VIII.2).
#pragma once

#include "kernels/autodiff/dual.h"
#include "kernels/autodiff/listing.h"
#include "kernels/autodiff/operations.h"
#include "kernels/equations/recording.h"
#include "kernels/equations/state.h"

namespace kagero {

/// What the tracing loop looks at wherever a step ends.
template <class V>
struct EventFunctions {
    Vec3<V> velocity;  ///< ∂K/∂p
    V excess, size;    ///< K, and |p·∂K/∂p| + |Ω H0|
    V terms;           ///< |p|²|∂K/∂p|² + (Ω H0)², which vanishes for no ray
    V domain;          ///< ≤ 0 beyond the edge of the medium
    V captured;        ///< ≤ 0 where a ray is captured
    V switching;            ///< changes sign where H is not smooth
    V max_step_length;           ///< no step from here may be longer
};

/// … from what its program returns.
template <class V>
KAGERO_INLINE EventFunctions<V> event_functions_of(const V* out) {
    return {{out[index_velocity], out[index_velocity + 1], out[index_velocity + 2]}, out[index_excess], out[index_size],
            out[index_terms], out[index_domain], out[index_captured], out[index_switching], out[index_max_step_length]};
}

/// Some of the three axes.
struct Axes {
    bool x = false, y = false, z = false;
    constexpr bool any() const { return x || y || z; }
};

/// K = ½|p|² + V(q), as Nyström methods want it: the force knows nothing of p, and the velocity is p.
template <class Force, class Velocity>
constexpr bool is_separable(const Force& force, const Velocity& velocity) {
    bool is_momentum = true;
    for (int k = 0; k < space_size; ++k) is_momentum = is_momentum && velocity.returns_input(k, momentum(k));
    return is_momentum && !force.uses_any_input(component_px, component_pt);
}

/// A program's uniforms, as numbers of type S, computed in double at least.
template <const auto& P, class S>
struct Uniforms {
    S values[P.uniforms + 1];
    explicit Uniforms(const double* parameters) {
        using Wide = decltype(S() + 1.0);
        Wide wide[P.uniforms + 1] = {}, k[parameter_limit] = {};
        for (int i = 0; i < P.parameters(); ++i) k[i] = Wide(parameters[i]);
        fill_uniforms(P.nodes, P.slot, P.size, k, wide);
        for (int i = 0; i < P.uniforms; ++i) values[i] = S(wide[i]);
    }

private:
    static constexpr int parameter_limit = P.parameters() + 1;
};

/// How many quantities rays carry along in a system: λ, and those of which it states the rates, if it does, by
///
///     static constexpr int carried = …;                                 // λ included
///     static constexpr bool carried_rates_need_p = …;                   // whether a rate depends on p
///     template <class V> void carried_rates(const State<V>&, V* rates)  // d/dτ of all but λ
template <class System>
constexpr int carried_in() {
    if constexpr (requires { System::carried; }) return System::carried;
    else return 1;
}
/// Why kinds of step that follow rays in closed form refuse a system; null where they do not.
template <class System>
constexpr const char* refusal_to_carry() {
    if (carried_in<System>() == 1) return nullptr;
    return "it moves rays in closed form and integrates nothing that they carry beside the parameter";
}

/// The two sides of Hamilton's equations, all that semi-implicit steps need.
template <class H, bool Rescaled, class S>
class Sides {
    static constexpr const auto& force_ = force_program<H, Rescaled>;
    static constexpr const auto& velocity_ = velocity_program<H, Rescaled>;

public:
    /// Whether ∂K/∂q depends on p, ∂K/∂p on q: where not, the half steps of eq. (9) are explicit.
    static constexpr bool force_needs_p = force_.uses_any_input(component_px, component_pt);
    static constexpr bool velocity_needs_q = velocity_.uses_any_input(component_x, component_px);
    static constexpr bool separable = is_separable(force_, velocity_);
    /// Coordinates that do not occur in K, as along the layers of a stratified medium: their momenta are constants of
    /// the motion.
    static constexpr Axes cyclic = [] {
        const auto is_cyclic = [](int k) {
            return force_.returns_zero(k) && !rescale_program<H>.uses_any_input(k, k + 1);
        };
        return Axes{is_cyclic(component_x), is_cyclic(component_y), is_cyclic(component_z)};
    }();

    explicit Sides(const double* parameters) : force_u_(parameters), velocity_u_(parameters) {}

    /// ∂K/∂q alone.
    template <class V>
    KAGERO_INLINE Vec3<V> dq(const State<V>& s) const { return side<force_>(force_u_.values, s); }
    /// ∂K/∂p alone: dq/dτ.
    template <class V>
    KAGERO_INLINE Vec3<V> dp(const State<V>& s) const { return side<velocity_>(velocity_u_.values, s); }
    /// ∂²K/∂q_i∂p_j (9, row by row): forward duals over the reverse program, all momenta at once where that is short
    /// and every step asks.
    template <class V>
    __attribute__((noinline)) void mixed(const State<V>& s, V* out) const {
        constexpr int together = stepped_by_newton<H> && force_.length() <= longest_unrolled ? space_size : 1;
        using Forward = Dual<V, together>;
        for (int from = 0; from < space_size; from += together) {
            Forward in[state_size], force[space_size];
            for (int k = 0; k < state_size; ++k) in[k] = Forward(s.y[k]);
            for (int k = 0; k < together; ++k) in[momentum(from + k)] = Forward::variable(s.y[momentum(from + k)], k);
            run<force_>(force_u_.values, in, force);
            for (int i = 0; i < space_size; ++i)
                for (int k = 0; k < together; ++k) out[space_size * i + from + k] = force[i].derivative[k];
        }
    }

protected:
    static constexpr int longest_unrolled = 100;
    /// Programs are unrolled where they are used. Long ones that steps of several kinds use are called instead; all
    /// others that are long, or not taken unasked, are used by the calls of called_system.h alone.
    template <const auto& P, class V>
    KAGERO_INLINE static void evaluate(const S* uniforms, const V* inputs, V* outputs) {
        if constexpr (separable && P.length() > longest_unrolled) run_called<P>(uniforms, inputs, outputs);
        else run<P>(uniforms, inputs, outputs);
    }
    /// ∂K/∂q to three places.
    template <class V>
    KAGERO_INLINE void put_dq(const State<V>& s, V* out) const { evaluate<force_>(force_u_.values, s.y, out); }

private:
    template <const auto& P, class V>
    __attribute__((noinline)) static void run_called(const S* uniforms, const V* inputs, V* outputs) {
        run<P>(uniforms, inputs, outputs);
    }
    template <const auto& P, class V>
    KAGERO_INLINE static Vec3<V> side(const S* uniforms, const State<V>& s) {
        V out[space_size];
        evaluate<P>(uniforms, s.y, out);
        return {out[0], out[1], out[2]};
    }

    Uniforms<force_program<H, Rescaled>, S> force_u_;
    Uniforms<velocity_program<H, Rescaled>, S> velocity_u_;
};

/// The parts H_A and H_B of the printed recipe, each as a system of its own.
template <class H, class S>
struct PartSystems {
    Sides<Part<H, false>, false, S> a;
    Sides<Part<H, true>, false, S> b;
    explicit PartSystems(const double* parameters) : a(parameters), b(parameters) {}
};
struct NoParts {
    explicit NoParts(const double*) {}
};

/// V(u) in the plane of an orbit in the guise of a Hamiltonian of u = q.x, du/dφ = p.x and 1/b² = p.y, so that the tape
/// differentiates it.
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
template <class H, class S>
class OrbitSystem : public Sides<OrbitPlane<H>, false, S> {
public:
    explicit OrbitSystem(const double* parameters)
        : Sides<OrbitPlane<H>, false, S>(parameters), energy_u_(parameters) {}
    /// ∂V/∂u.
    template <class V>
    KAGERO_INLINE V slope(const V& u, const V& g) const { return this->dq(at_rest(u, g)).x; }
    /// V.
    template <class V>
    KAGERO_INLINE V potential(const V& u, const V& g) const {
        V out[1];
        run<energy_program<OrbitPlane<H>>>(energy_u_.values, at_rest(u, g).y, out);
        return out[0];
    }

private:
    template <class V>
    KAGERO_INLINE static State<V> at_rest(const V& u, const V& g) {
        const V zero(S(0));
        return {{u, zero, zero, zero, g, zero, zero}};
    }
    Uniforms<energy_program<OrbitPlane<H>>, S> energy_u_;
};
struct NoOrbit {
    explicit NoOrbit(const double*) {}
};

template <class H, bool Rescaled, class S>
class System : public Sides<H, Rescaled, S> {
    static_assert(!Rescaled || Rescalable<H>);
    using Base = Sides<H, Rescaled, S>;
    static constexpr const auto& derivatives_ = derivatives_program<H, Rescaled>;
    static constexpr const auto& event_functions_ = event_functions_program<H, Rescaled>;

public:
    using Hamiltonian = H;
    static constexpr bool rescaled = Rescaled;
    /// Steps in it are compiled for all such systems together (called_system.h).
    static constexpr bool called = Rescaled != Rescalable<H> || derivatives_.length() > Base::longest_unrolled;
    /// What of a event_functions is more than the number 1.
    static constexpr bool bounded = Bounded<H>, capturing = Capturing<H>, discontinuous = HasDiscontinuity<H>,
                          bounds_steps = BoundsSteps<H>;

    static constexpr ProgramOperations operations = [] {
        ProgramOperations o{operations_of(derivatives_), operations_of(force_program<H, Rescaled>),
                            operations_of(velocity_program<H, Rescaled>), operations_of(event_functions_)};
        if constexpr (Orbiting<H>) o.slope = operations_of(force_program<OrbitPlane<H>, false>);
        return o;
    }();

    explicit System(const double* parameters)
        : Base(parameters), numbers_(parameters), parts_(parameters), orbit_(parameters), derivatives_u_(parameters),
          energy_u_(parameters), rescale_u_(parameters), event_functions_u_(parameters) {}
    /// H0.
    static constexpr S level() { return S(H::level); }
    const auto& part_a() const requires Parted<H> { return parts_.a; }
    const auto& part_b() const requires Parted<H> { return parts_.b; }
    const auto& orbit() const requires Orbiting<H> { return orbit_; }

    /// ∂K/∂(q, p), a `PhaseGradient`.
    template <class V>
    KAGERO_INLINE void derivatives(const State<V>& s, V* out) const {
        if constexpr (Base::separable) {
            out[component_px] = s.y[component_px];
            out[component_py] = s.y[component_py];
            out[component_pz] = s.y[component_pz];
            Base::put_dq(s, out);
        } else {
            Base::template evaluate<derivatives_>(derivatives_u_.values, s.y, out);
        }
    }
    /// ∂²K/∂(q, p)², a `Hessian`: forward duals over the reverse program, one variable at a time.
    template <class V>
    __attribute__((noinline)) void hessian(const State<V>& s, V* out) const {
        using Forward = Dual<V, 1>;
        for (int variable = 0; variable < phase_size; ++variable) {
            Forward in[state_size], g[phase_size];
            for (int k = 0; k < state_size; ++k) in[k] = Forward(s.y[k]);
            in[variable] = Forward::variable(s.y[variable], 0);
            run<derivatives_>(derivatives_u_.values, in, g);
            for (int k = 0; k < phase_size; ++k) out[hessian_index(k, variable)] = g[k].derivative[0];
        }
    }
    /// The program of `derivatives` as data.
    Listed<S> listed() const {
        return {{derivatives_.nodes, derivatives_.slot, derivatives_.outputs.data(), derivatives_.size},
                derivatives_u_.values};
    }
    /// The parameters, for flows that a Hamiltonian states in closed form.
    template <class V>
    KAGERO_INLINE auto parameters() const {
        V k[H::parameters.size() + 1];
        for (std::size_t i = 0; i < H::parameters.size(); ++i) k[i] = V(numbers_.k[i]);
        return make_parameters<H>(k);
    }
    /// H − H0, of the Hamiltonian itself.
    template <class V>
    KAGERO_INLINE V energy(const State<V>& s) const {
        V out[1];
        run<energy_program<H>>(energy_u_.values, s.y, out);
        return out[0];
    }
    template <class V>
    KAGERO_INLINE EventFunctions<V> event_functions(const State<V>& s) const {
        V out[event_function_count];
        run<event_functions_>(event_functions_u_.values, s.y, out);
        return event_functions_of(out);
    }
    /// dλ/dτ at the position in s.
    template <class V>
    KAGERO_INLINE V time_rescaling_factor(const State<V>& s) const {
        V out[1] = {V(S(1))};
        if constexpr (Rescaled) run<rescale_program<H>>(rescale_u_.values, s.y, out);
        return out[0];
    }

private:
    /// The parameters as S; room for one more, because a Hamiltonian may have none.
    struct Numbers {
        S k[H::parameters.size() + 1] = {};
        explicit Numbers(const double* parameters) {
            for (std::size_t i = 0; i < H::parameters.size(); ++i) k[i] = S(parameters[i]);
        }
    };
    template <class Self>
    static constexpr auto parts() {
        if constexpr (Parted<Self> && !Rescaled) return std::type_identity<PartSystems<Self, S>>{};
        else return std::type_identity<NoParts>{};
    }

    template <class Self>
    static constexpr auto orbit_plane() {
        if constexpr (Orbiting<Self> && !Rescaled) return std::type_identity<OrbitSystem<Self, S>>{};
        else return std::type_identity<NoOrbit>{};
    }

    Numbers numbers_;
    [[no_unique_address]] typename decltype(parts<H>())::type parts_;
    [[no_unique_address]] typename decltype(orbit_plane<H>())::type orbit_;
    Uniforms<derivatives_program<H, Rescaled>, S> derivatives_u_;
    Uniforms<energy_program<H>, S> energy_u_;
    Uniforms<rescale_program<H>, S> rescale_u_;
    Uniforms<event_functions_program<H, Rescaled>, S> event_functions_u_;
};

}  // namespace kagero

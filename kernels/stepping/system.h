/// From a scalar H to Hamilton's equations: dq/dλ = ∂H/∂p, dp/dλ = −∂H/∂q (Satoh 2003, eq. 7), by the tape.
///
/// `System<H, Rescaled, S>` holds a Hamiltonian's parameters as numbers of type S and runs its derivative programs on any value type
/// whose lanes are S. With `Rescaled` it is K = Ω(q)·(H − H0) multiplied through, which has the same rays on H = H0 in another
/// parameter τ, dλ = Ω dτ (Poincaré's time transformation; Hairer, Lubich & Wanner 2006, §VIII.2).
#pragma once

#include "kernels/numeric/dual.h"
#include "kernels/numeric/operations.h"
#include "kernels/numeric/program.h"
#include "kernels/numeric/vec.h"

namespace kagero {

/// Canonical state of rays: x y z px py pz, and the constant p_t behind them, as the programs read them.
template <class V>
struct State {
    V y[7];
    Vec3<V> q() const { return {y[0], y[1], y[2]}; }
    Vec3<V> p() const { return {y[3], y[4], y[5]}; }
    void set(const Vec3<V>& q, const Vec3<V>& p) { y[0] = q.x, y[1] = q.y, y[2] = q.z, y[3] = p.x, y[4] = p.y, y[5] = p.z; }
};

template <class H>
concept Rescalable = requires(const typename H::template Parameters<double>& k, const Vec3<double>& q) { H::rescale(k, q); };
template <class H>
concept Bounded = requires(const typename H::template Parameters<double>& k, const Vec3<double>& q) { H::domain(k, q); };
template <class H>
concept Capturing = requires(const typename H::template Parameters<double>& k, const Vec3<double>& q) { H::captured(k, q, q, 1.0); };
/// H is not smooth where `surface` is zero.
template <class H>
concept Creased = requires(const typename H::template Parameters<double>& k, const Vec3<double>& q) { H::surface(k, q); };
/// Bounds the length of steps.
template <class H>
concept Scaled = requires(const typename H::template Parameters<double>& k, const Vec3<double>& q) { H::length_scale(k, q); };
/// States H as a sum of two parts, the paper's H_A and H_B (eq. 10).
template <class H>
concept Parted = requires(const typename H::template Parameters<double>& k, const Vec3<double>& q) { H::part_a(k, q, q, 1.0); };
/// States the exact flow of H − ½(|p|² − p_t²).
template <class H>
concept ExactlySplit =
    requires(const typename H::template Parameters<double>& k, Vec3<double>& q) { H::flow_of_rest(k, q, q, 1.0, 1.0); };
template <class H>
concept SometimesStraight = requires(const typename H::template Parameters<double>& k) { H::straight(k); };

/// Parameters<S> filled from an array in declared order.
template <class H, class S>
constexpr auto make_parameters(const S* values) {
    return [&]<std::size_t... I>(std::index_sequence<I...>) {
        return typename H::template Parameters<S>{values[I]...};
    }(std::make_index_sequence<H::parameters.size()>{});
}

/// The leaves and the Hamiltonian of a tape.
template <class H>
struct Recording {
    std::array<int, 7> input{};
    int energy = -1;   ///< H − H0
    int rescale = -1;  ///< Ω, or the constant 1
    Recorded k[H::parameters.size() + 1];
    Vec3<Recorded> q, p;

    constexpr explicit Recording(Tape& t) {
        for (int i = 0; i < 7; ++i) input[i] = t.input(i);
        for (int i = 0; i < static_cast<int>(H::parameters.size()); ++i) k[i] = Recorded(&t, t.parameter(i));
        q = {{&t, input[0]}, {&t, input[1]}, {&t, input[2]}};
        p = {{&t, input[3]}, {&t, input[4]}, {&t, input[5]}};
        const auto parameters = make_parameters<H>(k);
        energy = t.sub(H::energy(parameters, q, p, Recorded(&t, input[6])).on(t), t.constant(H::level));
        if constexpr (Rescalable<H>) rescale = H::rescale(parameters, q).on(t);
        else rescale = t.constant(1);
    }
    /// H − H0, or K.
    constexpr int hamiltonian(Tape& t, bool rescaled) const { return rescaled ? multiply_through(t, rescale, energy) : energy; }
};

/// p·∂H/∂p from the leaves and the gradient of a tape.
constexpr int momentum_times_velocity(Tape& t, const std::array<int, 7>& input, const std::array<int, 6>& gradient) {
    return t.add(t.add(t.mul(input[3], gradient[3]), t.mul(input[4], gradient[4])), t.mul(input[5], gradient[5]));
}

/// What the tracing loop looks at wherever a step ends.
template <class V>
struct Survey {
    Vec3<V> velocity;  ///< ∂K/∂p
    V excess, size;    ///< K, and |p·∂K/∂p| + |Ω H0|
    V terms;           ///< |p|²|∂K/∂p|² + (Ω H0)², which vanishes for no ray
    V domain;          ///< ≤ 0 beyond the edge of the medium
    V captured;        ///< ≤ 0 where a ray is captured
    V side;            ///< changes sign where H is not smooth
    V scale;           ///< no step from here may be longer
};
inline constexpr int surveyed = 10;

/// The places of a survey on a tape, in the order of `Survey`; of what a Hamiltonian does not state, the number 1.
constexpr std::array<int, surveyed> record_survey(Tape& t, const std::array<int, 7>& input, int hamiltonian, int pace, double level,
                                                  const std::array<int, 6>& gradient) {
    const auto square = [&t](int a, int b, int c) { return t.add(t.add(t.mul(a, a), t.mul(b, b)), t.mul(c, c)); };
    const auto size = [&t](int a) { return t.binary(Op::max, a, t.neg(a)); };
    const int moving = momentum_times_velocity(t, input, gradient), resting = t.mul(pace, t.constant(level)), one = t.constant(1);
    const int squares = t.mul(square(input[3], input[4], input[5]), square(gradient[3], gradient[4], gradient[5]));
    return {gradient[3], gradient[4], gradient[5], hamiltonian, t.add(size(moving), size(resting)),
            t.add(squares, t.mul(resting, resting)), one, one, one, one};
}

/// The gradient by x y z px py pz.
constexpr std::array<int, 6> record_derivatives(Tape& t, int hamiltonian, const std::array<int, 7>& input) {
    std::array<int, 6> wanted{}, gradient{};
    for (int i = 0; i < 6; ++i) wanted[i] = input[i];
    record_gradient<6>(t, hamiltonian, wanted, gradient);
    return gradient;
}

/// K = ½|p|² + V(q), as Nyström methods want it: the force knows nothing of p, and the velocity is p.
template <class Force, class Velocity>
constexpr bool is_separable(const Force& force, const Velocity& velocity) {
    return !force.uses_any_input(3, 6) && velocity.returns_input(0, 3) && velocity.returns_input(1, 4) && velocity.returns_input(2, 5);
}

/// What stays and what varies while the implicit halves of eq. (9) are solved.
inline constexpr Varying kick_varies{3, 6}, drift_varies{0, 3};

/// Everything the programs of a Hamiltonian are cut from: one tape, recorded once by the compiler.
template <class H, bool Rescaled>
struct Master {
    Tape tape{};
    std::array<int, 6> gradient{};  ///< ∂K/∂(x y z px py pz)
    std::array<int, 1> energy{};    ///< H − H0 (of H: present where not Rescaled)
    std::array<int, 1> pace{};      ///< Ω
    std::array<int, surveyed> survey{};

    constexpr Master() {
        Tape& t = tape;
        const Recording<H> r(t);
        const int k = r.hamiltonian(t, Rescaled);
        gradient = record_derivatives(t, k, r.input);
        pace = {r.rescale};
        survey = record_survey(t, r.input, k, Rescaled ? r.rescale : t.constant(1), H::level, gradient);
        if constexpr (!Rescaled) energy = {r.energy};
        const auto parameters = make_parameters<H>(r.k);
        const Vec3<Recorded> velocity{{&t, gradient[3]}, {&t, gradient[4]}, {&t, gradient[5]}};
        if constexpr (Bounded<H>) survey[6] = H::domain(parameters, r.q).on(t);
        if constexpr (Capturing<H>) survey[7] = H::captured(parameters, r.q, velocity, Recorded(&t, r.input[6])).on(t);
        if constexpr (Creased<H>) survey[8] = H::surface(parameters, r.q).on(t);
        if constexpr (Scaled<H>) survey[9] = H::length_scale(parameters, r.q).on(t);
    }
    constexpr std::array<int, 3> side(int from) const { return {gradient[from], gradient[from + 1], gradient[from + 2]}; }
};
template <class H, bool Rescaled>
inline constexpr Master<H, Rescaled> master{};

/// The programs.
template <class H, bool Rescaled>
inline constexpr auto derivatives_program = extract<master<H, Rescaled>, master<H, Rescaled>.gradient>();
template <class H, bool Rescaled>
inline constexpr auto force_program = extract<master<H, Rescaled>, master<H, Rescaled>.side(0), kick_varies>();
template <class H, bool Rescaled>
inline constexpr auto velocity_program = extract<master<H, Rescaled>, master<H, Rescaled>.side(3), drift_varies>();
template <class H>
inline constexpr auto energy_program = extract<master<H, false>, master<H, false>.energy>();
template <class H>
inline constexpr auto rescale_program = extract<master<H, false>, master<H, false>.pace>();
template <class H, bool Rescaled>
inline constexpr auto survey_program = extract<master<H, Rescaled>, master<H, Rescaled>.survey>();

/// A program's uniforms, as numbers of type S, computed in double at least.
template <const auto& P, class S>
struct Uniforms {
    S values[P.uniforms + 1];
    explicit Uniforms(const double* parameters) {
        using Wide = decltype(S() + 1.0);
        Wide wide[P.uniforms + 1] = {}, k[parameter_limit] = {};
        for (int i = 0; i < P.parameters(); ++i) k[i] = Wide(parameters[i]);
        fill_uniforms<P>(k, wide);
        for (int i = 0; i < P.uniforms; ++i) values[i] = S(wide[i]);
    }

private:
    static constexpr int parameter_limit = P.parameters() + 1;
};

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

template <class H, bool Rescaled, class S>
class System;

template <class H, class S>
struct PartSystems {
    System<Part<H, false>, false, S> a;
    System<Part<H, true>, false, S> b;
    explicit PartSystems(const double* parameters) : a(parameters), b(parameters) {}
};
struct NoParts {
    explicit NoParts(const double*) {}
};

template <class H, bool Rescaled, class S>
class System {
    static_assert(!Rescaled || Rescalable<H>);
    static constexpr const auto& derivatives_ = derivatives_program<H, Rescaled>;
    static constexpr const auto& force_ = force_program<H, Rescaled>;
    static constexpr const auto& velocity_ = velocity_program<H, Rescaled>;

public:
    using Hamiltonian = H;
    static constexpr bool rescaled = Rescaled;
    /// Whether ∂K/∂q depends on p, ∂K/∂p on q: where not, the half steps of eq. (9) are explicit.
    static constexpr bool force_needs_p = force_.uses_any_input(3, 6);
    static constexpr bool velocity_needs_q = velocity_.uses_any_input(0, 3);
    static constexpr bool separable = is_separable(force_, velocity_);
    /// What of a survey is more than the number 1.
    static constexpr bool bounded = Bounded<H>, capturing = Capturing<H>, creased = Creased<H>, scaled = Scaled<H>;

    static constexpr ProgramOperations operations{
        operations_of(derivatives_), operations_of(force_), operations_of(velocity_), operations_of(survey_program<H, Rescaled>)};

    explicit System(const double* parameters)
        : numbers_(parameters), parts_(parameters), derivatives_u_(parameters), force_u_(parameters), velocity_u_(parameters),
          energy_u_(parameters), rescale_u_(parameters), survey_u_(parameters) {}
    /// H0.
    static constexpr S level() { return S(H::level); }
    /// The parts H_A and H_B as systems of their own.
    const auto& part_a() const requires Parted<H> { return parts_.a; }
    const auto& part_b() const requires Parted<H> { return parts_.b; }

    /// out = ∂K/∂q (3), ∂K/∂p (3).
    template <class V>
    KAGERO_INLINE void derivatives(const State<V>& s, V* out) const { run<derivatives_>(derivatives_u_.values, s.y, out); }
    /// ∂K/∂q alone.
    template <class V>
    KAGERO_INLINE Vec3<V> dq(const State<V>& s) const { return side<force_>(force_u_.values, s); }
    /// ∂K/∂p alone: dq/dτ.
    template <class V>
    KAGERO_INLINE Vec3<V> dp(const State<V>& s) const { return side<velocity_>(velocity_u_.values, s); }
    /// ∂²K/∂q_i∂p_j (9, row by row): forward duals over the reverse program.
    template <class V>
    KAGERO_INLINE void mixed(const State<V>& s, V* out) const {
        using Forward = Dual<V, 3>;
        Forward in[7], force[3];
        for (int k = 0; k < 7; ++k) in[k] = k >= 3 && k < 6 ? Forward::variable(s.y[k], k - 3) : Forward(s.y[k]);
        run<force_>(force_u_.values, in, force);
        for (int i = 0; i < 3; ++i)
            for (int k = 0; k < 3; ++k) out[3 * i + k] = force[i].derivative[k];
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
    KAGERO_INLINE Survey<V> survey(const State<V>& s) const {
        V out[surveyed];
        run<survey_program<H, Rescaled>>(survey_u_.values, s.y, out);
        return {{out[0], out[1], out[2]}, out[3], out[4], out[5], out[6], out[7], out[8], out[9]};
    }
    /// dλ/dτ at the position in s.
    template <class V>
    KAGERO_INLINE V pace(const State<V>& s) const {
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
    template <const auto& P, class V>
    KAGERO_INLINE static Vec3<V> side(const S* uniforms, const State<V>& s) {
        V out[3];
        run<P>(uniforms, s.y, out);
        return {out[0], out[1], out[2]};
    }

    template <class Self>
    static constexpr auto parts() {
        if constexpr (Parted<Self> && !Rescaled) return std::type_identity<PartSystems<Self, S>>{};
        else return std::type_identity<NoParts>{};
    }

    Numbers numbers_;
    [[no_unique_address]] typename decltype(parts<H>())::type parts_;
    Uniforms<derivatives_program<H, Rescaled>, S> derivatives_u_;
    Uniforms<force_program<H, Rescaled>, S> force_u_;
    Uniforms<velocity_program<H, Rescaled>, S> velocity_u_;
    Uniforms<energy_program<H>, S> energy_u_;
    Uniforms<rescale_program<H>, S> rescale_u_;
    Uniforms<survey_program<H, Rescaled>, S> survey_u_;
};

}  // namespace kagero

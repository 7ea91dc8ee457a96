/// Hamilton's equations of one ray by forward-mode differentiation, with the components of the gradient in the lanes.
/// The strategy `per-ray` uses them in its form `gradient`. All functions except the derivatives are inherited from
/// `System`.
#pragma once

#include "kernels/comparison/forward.h"
#include "kernels/equations/system.h"

namespace kagero {

/// A tape that contains K but not its derivatives. Forward-mode differentiation is applied to it. K is H − H0, or
/// Ω·(H − H0) if `Rescaled` is true.
template <class H, bool Rescaled>
struct PrimalTape {
    Tape tape{};
    std::array<int, 1> value{};  ///< Node of K.
    constexpr PrimalTape() {
        const Recording<H> r(tape);
        value = {r.hamiltonian(tape, Rescaled)};
    }
};
template <class H, bool Rescaled>
inline constexpr PrimalTape<H, Rescaled> primal_tape{};
template <class H, bool Rescaled>
inline constexpr auto primal_program = extract<primal_tape<H, Rescaled>, primal_tape<H, Rescaled>.value>();

template <class H, bool Rescaled, class S>
class ForwardSystem;

/// The parts H_A and H_B of H (Satoh 2003, eq. 10), each as a system. The recipe as printed integrates them in turn.
template <class H, class S>
struct ForwardParts {
    ForwardSystem<Part<H, false>, false, S> a;
    ForwardSystem<Part<H, true>, false, S> b;
    explicit ForwardParts(const double* parameters) : a(parameters), b(parameters) {}
};

/// A system whose derivatives are computed by forward-mode differentiation.
template <class H, bool Rescaled, class S>
class ForwardSystem : public System<H, Rescaled, S> {
    static constexpr const auto& primal_ = primal_program<H, Rescaled>;
    static constexpr const auto& force_ = force_program<H, Rescaled>;

public:
    explicit ForwardSystem(const double* parameters)
        : System<H, Rescaled, S>(parameters), parts_(parameters), primal_uniforms_(parameters),
          force_uniforms_(parameters) {}
    const auto& part_a() const requires Parted<H> { return parts_.a; }
    const auto& part_b() const requires Parted<H> { return parts_.b; }

    KAGERO_INLINE void derivatives(const State<S>& s, S* out) const { gradient<component_x, phase_size>(s, out); }
    KAGERO_INLINE Vec3<S> gradient_q(const State<S>& s) const { return gradient_half<component_x>(s); }
    KAGERO_INLINE Vec3<S> gradient_p(const State<S>& s) const { return gradient_half<component_px>(s); }
    /// Computes the matrix ∂²K/∂q_i∂p_j by forward-mode differentiation of the program of ∂K/∂q.
    KAGERO_INLINE void mixed(const State<S>& s, S* out) const {
        Packed<S, space_size> row[space_size];
        run_forward<force_, component_px, phase_size>(force_uniforms_.values, s.y, row);
        for (int i = 0; i < space_size; ++i)
            for (int k = 0; k < space_size; ++k) out[space_size * i + k] = get_lane(row[i], k);
    }

private:
    /// Computes the derivatives of K with respect to the components [first, last) of the state.
    template <int first, int last>
    KAGERO_INLINE void gradient(const State<S>& s, S* out) const {
        Packed<S, last - first> g;
        run_forward<primal_, first, last>(primal_uniforms_.values, s.y, &g);
        for (int k = 0; k < last - first; ++k) out[k] = get_lane(g, k);
    }
    /// Returns one half of the gradient: ∂K/∂q or ∂K/∂p.
    template <int first>
    KAGERO_INLINE Vec3<S> gradient_half(const State<S>& s) const {
        S g[space_size];
        gradient<first, first + space_size>(s, g);
        return {g[0], g[1], g[2]};
    }
    /// Returns the type of `parts_` in a std::type_identity. This function is a template, so that ForwardParts is
    /// instantiated only if H has parts.
    template <class AnyH>
    static constexpr auto parts_type() {
        if constexpr (Parted<AnyH> && !Rescaled) return std::type_identity<ForwardParts<AnyH, S>>{};
        else return std::type_identity<NoParts>{};
    }

    [[no_unique_address]] typename decltype(parts_type<H>())::type parts_;
    Uniforms<primal_program<H, Rescaled>, S> primal_uniforms_;
    Uniforms<force_program<H, Rescaled>, S> force_uniforms_;
};

}  // namespace kagero

#pragma once

#include "kernels/hamiltonians/hamiltonian.h"

namespace kagero::hamiltonians {

/// Ellis's wormhole: two universes joined by a throat, in isotropic coordinates.
///
///     H = ½ (|p|² / (1 + a²/4ρ²)² − p_t²),  ρ = |x|       Ellis (1973); Müller (2004)
///
/// x in scene lengths, a the radius of the throat. The proper distance from the throat is l = ρ − a²/4ρ: ρ > a/2 is
/// this universe, and the sphere ρ < a/2 is the other one, whole, turned inside out by ρ → a²/4ρ. The areal radius is
/// √(l² + a²) = ρ + a²/4ρ. Light rays have H = 0. Conserved: H, p_t, x × p. A ray with the impact parameter b passes
/// through where b < a, comes back where b > a.
///
/// Domain: ρ > 0. `escape_radius` is |l|, on both sides.
struct Wormhole {
    static constexpr const char* name = "wormhole";
    static constexpr const char* what = "Ellis wormhole between two universes";
    static constexpr const char* formula = "H = (|p|^2/(1 + a^2/(4 r^2))^2 - pt^2)/2, a = throat";
    static constexpr const char* source = "Ellis (1973); Mueller (2004)";
    static constexpr const char* conserved = "pt, x cross p";
    static constexpr std::array parameters{
        ParameterInfo{"throat", 1.0, 0, unlimited, true, Unit::length, "radius of the throat, a"},
    };
    static constexpr bool spacetime = true;
    static constexpr double level = 0;
    static constexpr const char* method = "rkf78";
    static constexpr double step = 0.25;

    template <class V>
    struct Parameters {
        V throat;
    };

    template <class V>
    static constexpr V energy(const Parameters<V>& k, const Vec3<V>& q, const Vec3<V>& p, const V& pt) {
        const V shrink = 1.0 / (1.0 + 0.25 * k.throat * k.throat / dot(q, q));
        return 0.5 * (shrink * shrink * dot(p, p) - pt * pt);
    }

    template <class V>
    static constexpr V part_a(const Parameters<V>&, const Vec3<V>&, const Vec3<V>&, const V& pt) {
        return -0.5 * (pt * pt);
    }
    template <class V>
    static constexpr V part_b(const Parameters<V>& k, const Vec3<V>& q, const Vec3<V>& p, const V&) {
        return energy(k, q, p, V(0.0));
    }

    /// The areal radius: as long a scale on this side as on the other.
    template <class V>
    static constexpr V rescale(const Parameters<V>& k, const Vec3<V>& q) {
        const V r = norm(q);
        return r + 0.25 * k.throat * k.throat / r;
    }

    /// Half of the areal radius in proper length: a longer step leaps through the throat.
    template <class V>
    static constexpr V max_step_length(const Parameters<V>&, const Vec3<V>& q) {
        return 0.5 * norm(q);
    }

    /// The plane of an orbit: with p along the ray, u² + (du/dφ)² = |p|²/L², and H = 0 tells |p|. L dλ = R² dφ, R the
    /// areal radius.
    template <class V>
    static constexpr V orbit_potential(const Parameters<V>& k, const V& u, const V& g) {
        const V s = 0.25 * k.throat * k.throat * u * u;
        return 0.5 * u * u - 0.5 * g * s * (2.0 + s);
    }
    template <class V>
    static constexpr V orbit_delay(const Parameters<V>& k, const V& u) {
        const V square = 0.25 * k.throat * k.throat;
        return square * (2.0 + square * u * u);
    }
    static constexpr const char* orbit_method = "orbit-srkn11";
    static constexpr double orbit_step = 0.3;

    template <class V>
    static constexpr V throat_radius(const Parameters<V>& k) {
        return 0.5 * k.throat;
    }
};

}  // namespace kagero::hamiltonians

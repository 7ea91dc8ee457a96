#pragma once

#include "kernels/hamiltonians/hamiltonian.h"

namespace kagero::hamiltonians {

/// The Ellis wormhole: two sheets that are joined by a throat, in isotropic coordinates.
///
///     H = ½ (|p|² / (1 + a²/4ρ²)² − p_t²),  ρ = |x|       Ellis (1973); Müller (2004)
///
/// Coordinates: isotropic Cartesian x, y, z relative to the centre. Units: scene lengths; a is the radius of the
/// throat. Level: H0 = 0, null rays. Conserved: H, p_t, x × p. Domain: ρ > 0; `escape_radius` is a bound on |l| on both
/// sheets.
///
/// The proper distance from the throat is l = ρ − a²/4ρ. The first sheet is ρ > a/2. The second sheet is ρ < a/2, the
/// image of the first by the inversion ρ → a²/4ρ. The areal radius is √(l² + a²) = ρ + a²/4ρ. A ray with the impact
/// parameter b passes through the throat if b < a, and returns if b > a.
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
        const V inverse_scale = 1.0 / (1.0 + 0.25 * k.throat * k.throat / dot(q, q));
        return 0.5 * (inverse_scale * inverse_scale * dot(p, p) - pt * pt);
    }

    template <class V>
    static constexpr V part_a(const Parameters<V>&, const Vec3<V>&, const Vec3<V>&, const V& pt) {
        return -0.5 * (pt * pt);
    }
    template <class V>
    static constexpr V part_b(const Parameters<V>& k, const Vec3<V>& q, const Vec3<V>& p, const V&) {
        return energy(k, q, p, V(0.0));
    }

    /// Ω is the areal radius, a length scale that is symmetric in the two sheets.
    template <class V>
    static constexpr V rescale(const Parameters<V>& k, const Vec3<V>& q) {
        const V r = norm(q);
        return r + 0.25 * k.throat * k.throat / r;
    }

    /// Returns ρ/2; the proper length of such a step is half of the areal radius. A longer step could jump through the
    /// throat.
    template <class V>
    static constexpr V max_step_length(const Parameters<V>&, const Vec3<V>& q) {
        return 0.5 * norm(q);
    }

    /// V(u) follows from u² + (du/dφ)² = |p|²/L², which holds because p is parallel to the ray, and from H = 0, which
    /// determines |p|. L dλ = R² dφ, where R is the areal radius, determines orbit_delay.
    template <class V>
    static constexpr V orbit_potential(const Parameters<V>& k, const V& u, const V& g) {
        const V s = 0.25 * k.throat * k.throat * u * u;  // a²/4ρ²
        return 0.5 * u * u - 0.5 * g * s * (2.0 + s);
    }
    template <class V>
    static constexpr V orbit_delay(const Parameters<V>& k, const V& u) {
        const V quarter_a2 = 0.25 * k.throat * k.throat;
        return quarter_a2 * (2.0 + quarter_a2 * u * u);
    }
    static constexpr const char* orbit_method = "orbit-srkn11";
    static constexpr double orbit_step = 0.3;

    /// The throat in isotropic coordinates, ρ = a/2.
    template <class V>
    static constexpr V throat_radius(const Parameters<V>& k) {
        return 0.5 * k.throat;
    }
};

}  // namespace kagero::hamiltonians

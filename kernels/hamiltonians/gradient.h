#pragma once

#include "kernels/hamiltonians/hamiltonian.h"

namespace kagero::hamiltonians {

/// A medium whose squared index is linear in the height: every ray is a parabola.
///
///     H = ½ (|p|² − N²),  N² = n0² − g z                 Born & Wolf, §3.2
///
/// Coordinates: Cartesian, z up. Units: scene lengths; n0 is a number, g an inverse length. Level: H0 = 0. Conserved:
/// p_x, p_y. Domain: N² > 0; no ray leaves it, because |p|² = N². The exact solution is z = z0 + p_z λ − g λ²/4.
struct Gradient : IndexMedium<Gradient> {
    static constexpr const char* name = "gradient";
    static constexpr const char* what = "medium whose squared index is linear in z: parabolic rays";
    static constexpr const char* formula = "H = (|p|^2 - N^2)/2, N^2 = n0^2 - g z";
    static constexpr const char* source = "Born & Wolf, Principles of Optics, sec. 3.2";
    static constexpr const char* conserved = "px, py";
    static constexpr std::array parameters{
        ParameterInfo{"n0", 1.0, 0, unlimited, true, Unit::number, "index at z = 0"},
        ParameterInfo{"g", 0.1, -unlimited, unlimited, false, Unit::per_length, "decrease of N^2 per unit of height"},
    };
    static constexpr double step = 0.2;
    static constexpr const char* step_goes_with = "1/abs(g)";
    static constexpr const char* index_parameter = "n0";

    template <class V>
    struct Parameters {
        V n0, g;
    };

    template <class V>
    static constexpr V index_squared(const Parameters<V>& k, const Vec3<V>& q) {
        return k.n0 * k.n0 - k.g * q.z;
    }
};

}  // namespace kagero::hamiltonians

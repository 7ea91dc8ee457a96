#pragma once

#include "kernels/hamiltonians/hamiltonian.h"

namespace kagero::hamiltonians {

/// Maxwell's fisheye: a medium whose index decreases with the radius, in which every ray is a circle.
///
///     H = ½ (|p|² − N²),  N = n0 / (1 + r²/R²)           Maxwell (1854); Born & Wolf, §4.2.2
///
/// Coordinates: Cartesian, relative to the centre. Units: scene lengths; n0 is a number. Level: H0 = 0. Conserved:
/// x × p. Domain: all of space. Each ray is a circle that intersects the sphere r = R at two opposite points.
struct Fisheye : IndexMedium<Fisheye> {
    static constexpr const char* name = "fisheye";
    static constexpr const char* what = "Maxwell's fisheye: every ray is a circle";
    static constexpr const char* formula = "H = (|p|^2 - N^2)/2, N = n0/(1 + r^2/R^2)";
    static constexpr const char* source = "Maxwell (1854); Born & Wolf, Principles of Optics, sec. 4.2.2";
    static constexpr const char* conserved = "x cross p";
    static constexpr std::array parameters{
        ParameterInfo{"n0", 2.0, 0, unlimited, true, Unit::number, "index at the centre"},
        ParameterInfo{"radius", 1.0, 0, unlimited, true, Unit::length, "R, where N = n0/2"},
    };
    static constexpr double step = 0.05;
    static constexpr const char* step_goes_with = "radius";
    static constexpr const char* index_parameter = "n0";

    template <class V>
    struct Parameters {
        V n0, radius;
    };

    template <class V>
    static constexpr V index_squared(const Parameters<V>& k, const Vec3<V>& q) {
        const V index = k.n0 / (1.0 + dot(q, q) / (k.radius * k.radius));
        return index * index;
    }

    /// V(u) follows from u² + (du/dφ)² = N²/L².
    template <class V>
    static constexpr V orbit_potential(const Parameters<V>& k, const V& u, const V& g) {
        const V s = k.radius * k.radius * u * u, index = k.n0 * s / (1.0 + s);
        return 0.5 * u * u - 0.5 * g * index * index;
    }
};

}  // namespace kagero::hamiltonians

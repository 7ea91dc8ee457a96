#pragma once

#include "kernels/hamiltonians/hamiltonian.h"

namespace kagero::hamiltonians {

/// Empty space: straight rays.
///
///     H = ½ (|p|² − 1)                                   Satoh (2003), eqs. (1)–(4)
///
/// Coordinates: Cartesian. Units: scene lengths. Level: H0 = 0, so that |p| = |dq/dλ| = 1 and λ is the arc length.
/// Conserved: p, x × p. Domain: all of space.
struct Flat {
    static constexpr const char* name = "flat";
    static constexpr const char* what = "empty space: straight rays";
    static constexpr const char* formula = "H = (|p|^2 - 1)/2";
    static constexpr const char* source = "Satoh (2003), eqs. (1)-(4)";
    static constexpr const char* conserved = "p, x cross p";
    static constexpr std::array<ParameterInfo, 0> parameters{};
    static constexpr bool spacetime = false;
    static constexpr double level = 0;
    static constexpr const char* method = "verlet";
    static constexpr double step = 0.1;

    template <class V>
    struct Parameters {};

    template <class V>
    static constexpr V energy(const Parameters<V>&, const Vec3<V>&, const Vec3<V>& p, const V&) {
        return 0.5 * (dot(p, p) - 1.0);
    }

    static constexpr bool straight(const Parameters<double>&) { return true; }
};

}  // namespace kagero::hamiltonians

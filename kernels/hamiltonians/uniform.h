#pragma once

#include "kernels/hamiltonians/hamiltonian.h"

namespace kagero::hamiltonians {

/// A medium with the same index everywhere, such as glass or water: straight rays.
///
///     H = ½ (|p|² − n0²)                                 Born & Wolf, §3.2
///
/// Coordinates: Cartesian. Units: scene lengths; n0 is a number. Level: H0 = 0, so that |p| = |dq/dλ| = n0, and the arc
/// length is n0 λ. Conserved: p, x × p. Domain: all of space.
struct Uniform : IndexMedium<Uniform> {
    static constexpr const char* name = "uniform";
    static constexpr const char* what = "a medium with the same index everywhere: straight rays";
    static constexpr const char* formula = "H = (|p|^2 - n0^2)/2";
    static constexpr const char* source = "Born & Wolf, Principles of Optics, sec. 3.2";
    static constexpr const char* conserved = "p, x cross p";
    static constexpr std::array parameters{
        ParameterInfo{"n0", 1.5, 0, unlimited, true, Unit::number, "index of refraction"},
    };
    static constexpr const char* method = "verlet";
    static constexpr double step = 0.1;
    static constexpr const char* index_parameter = "n0";

    template <class V>
    struct Parameters {
        V n0;
    };

    template <class V>
    static constexpr V index_squared(const Parameters<V>& k, const Vec3<V>&) {
        return k.n0 * k.n0;
    }

    static constexpr bool straight(const Parameters<double>&) { return true; }
};

}  // namespace kagero::hamiltonians

#pragma once

#include "kernels/hamiltonians/hamiltonian.h"

namespace kagero::hamiltonians {

/// The Luneburg lens: a ball that focuses parallel light to a point on its surface.
///
///     H = ½ (|p|² − N²),  N² = 2 − r²/R² inside, 1 outside      Luneburg (1944); Born & Wolf, §4.2
///
/// Coordinates: Cartesian, relative to the centre. Units: scene lengths. Level: H0 = 0. Conserved: x × p. Domain: all
/// of space. Rays are arcs of ellipses about the centre inside the ball, and straight outside. N is continuous at the
/// surface of the ball but its gradient is not, so that steps end there.
struct Luneburg : IndexMedium<Luneburg> {
    static constexpr const char* name = "luneburg";
    static constexpr const char* what = "Luneburg lens: focuses parallel light to a point of its surface";
    static constexpr const char* formula = "H = (|p|^2 - N^2)/2, N^2 = 2 - r^2/R^2 inside R, 1 outside";
    static constexpr const char* source = "Luneburg (1944); Born & Wolf, Principles of Optics, sec. 4.2";
    static constexpr const char* conserved = "x cross p";
    static constexpr std::array parameters{
        ParameterInfo{"radius", 1.0, 0, unlimited, true, Unit::length, "R, radius of the ball"},
    };
    static constexpr const char* method = "gauss8";  // no stage lies at an end of a step, where the gradient jumps
    static constexpr double step = 0.25;
    static constexpr const char* step_goes_with = "radius";

    template <class V>
    struct Parameters {
        V radius;
    };

    template <class V>
    static constexpr V index_squared(const Parameters<V>& k, const Vec3<V>& q) {
        return 1.0 + max(switching_function(k, q), V(0.0));
    }

    template <class V>
    static constexpr V switching_function(const Parameters<V>& k, const Vec3<V>& q) {
        return 1.0 - dot(q, q) / (k.radius * k.radius);
    }

    template <class V>
    static constexpr V bending_radius(const Parameters<V>& k) {
        return k.radius;
    }
};

}  // namespace kagero::hamiltonians

#pragma once

#include "kernels/hamiltonians/hamiltonian.h"

namespace kagero::hamiltonians {

/// A graded-index fibre: rays oscillate about its axis.
///
///     H = ½ (|p|² − N²),  N² = n0² (1 − α² (x² + y²))     Snyder & Love (1983), §1-8
///
/// Coordinates: Cartesian, axis z. Units: scene lengths; n0 is a number, α an inverse length. Level: H0 = 0. Conserved:
/// p_z, x p_y − y p_x. Domain: N² > 0; no ray leaves it, because |p|² = N². x and y oscillate harmonically in λ with
/// the angular frequency n0 α.
struct Fiber : IndexMedium<Fiber> {
    static constexpr const char* name = "fiber";
    static constexpr const char* what = "graded-index fibre along z";
    static constexpr const char* formula = "H = (|p|^2 - N^2)/2, N^2 = n0^2 (1 - alpha^2 (x^2 + y^2))";
    static constexpr const char* source = "Born & Wolf, Principles of Optics; Snyder & Love (1983), sec. 1-8";
    static constexpr const char* conserved = "pz, x py - y px";
    static constexpr std::array parameters{
        ParameterInfo{"n0", 1.5, 0, unlimited, true, Unit::number, "index on the axis"},
        ParameterInfo{"alpha", 0.3, 0, unlimited, true, Unit::per_length, "inverse of the radius at which N = 0"},
    };
    static constexpr double step = 0.1;
    static constexpr const char* step_goes_with = "1/alpha";
    static constexpr const char* index_parameter = "n0";

    template <class V>
    struct Parameters {
        V n0, alpha;
    };

    template <class V>
    static constexpr V index_squared(const Parameters<V>& k, const Vec3<V>& q) {
        const V n2 = k.n0 * k.n0, slope = k.n0 * k.alpha;
        return n2 - slope * slope * (q.x * q.x + q.y * q.y);
    }
};

}  // namespace kagero::hamiltonians

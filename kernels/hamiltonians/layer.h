#pragma once

#include "kernels/hamiltonians/hamiltonian.h"

namespace kagero::hamiltonians {

/// A smooth layer between two media: Snell's law of refraction, and total reflection, with a thickness.
///
///     H = ½ (|p|² − N²),  N² = (n_b² + n_a²)/2 + (n_a² − n_b²)/2 · tanh(z/thickness)     Epstein (1930)
///
/// Cartesian coordinates, z up, H0 = 0. Conserved: p_x, p_y, hence Snell's law between z → −∞ and z → +∞. Domain: all
/// of space. However thin the layer is, steps shrink on the way to it: their number grows with log(1/thickness) alone.
struct Layer : IndexMedium<Layer> {
    static constexpr const char* name = "layer";
    static constexpr const char* what = "smooth transition between two indices: refraction and total reflection";
    static constexpr const char* formula =
        "H = (|p|^2 - N^2)/2, N^2 = (nb^2 + na^2)/2 + (na^2 - nb^2)/2 tanh(z/thickness)";
    static constexpr const char* source = "Epstein (1930), the transition layer";
    static constexpr const char* conserved = "px, py";
    static constexpr std::array parameters{
        ParameterInfo{"n_below", 1.5, 0, unlimited, true, Unit::number, "index far below"},
        ParameterInfo{"n_above", 1.0, 0, unlimited, true, Unit::number, "index far above"},
        ParameterInfo{"thickness", 0.1, 0, unlimited, true, Unit::length, "of the transition"},
    };
    static constexpr double step = 50;  // max_step_length bounds it
    static constexpr const char* step_goes_with = "escape_radius";

    template <class V>
    struct Parameters {
        V n_below, n_above, thickness;
    };

    template <class V>
    static constexpr V index_squared(const Parameters<V>& k, const Vec3<V>& q) {
        const V below = k.n_below * k.n_below, above = k.n_above * k.n_above;
        return 0.5 * (below + above) + 0.5 * (above - below) * tanh(q.z / k.thickness);
    }

    /// A tenth of the thickness in the layer, of the distance from its middle outside: no step reaches across.
    template <class V>
    static constexpr V max_step_length(const Parameters<V>& k, const Vec3<V>& q) {
        return 0.1 * max(k.thickness, max(q.z, -q.z));
    }
};

}  // namespace kagero::hamiltonians

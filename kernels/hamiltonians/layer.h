#pragma once

#include "kernels/hamiltonians/hamiltonian.h"

namespace kagero::hamiltonians {

/// A smooth layer between two media: refraction and total reflection at a boundary of finite thickness.
///
///     H = ½ (|p|² − N²),  N² = (n_b² + n_a²)/2 + (n_a² − n_b²)/2 · tanh(z/thickness)     Epstein (1930)
///
/// Coordinates: Cartesian, z up. Units: scene lengths; n_a and n_b are numbers. Level: H0 = 0. Conserved: p_x, p_y,
/// which is Snell's law between z → −∞ and z → +∞. Domain: all of space. Steps become shorter towards the layer, so
/// that their number grows only with log(1/thickness).
struct Layer : IndexMedium<Layer> {
    static constexpr const char* name = "layer";
    static constexpr const char* what = "smooth transition between two indices: refraction and total reflection";
    static constexpr const char* formula =
        "H = (|p|^2 - N^2)/2, N^2 = (nb^2 + na^2)/2 + (na^2 - nb^2)/2 tanh(z/thickness)";
    static constexpr const char* source = "Epstein (1930), the transition layer";
    static constexpr const char* conserved = "px, py";
    static constexpr std::array parameters{
        ParameterInfo{"n_below", 1.5, 0, unlimited, true, Unit::number, "n_b, the index for z -> -infinity"},
        ParameterInfo{"n_above", 1.0, 0, unlimited, true, Unit::number, "n_a, the index for z -> +infinity"},
        ParameterInfo{"thickness", 0.1, 0, unlimited, true, Unit::length, "thickness of the layer"},
    };
    static constexpr double step = 50;  // the actual steps are limited by max_step_length
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

    /// Returns a tenth of the thickness inside the layer, and a tenth of |z| outside, so that no step crosses the
    /// layer.
    template <class V>
    static constexpr V max_step_length(const Parameters<V>& k, const Vec3<V>& q) {
        return 0.1 * max(k.thickness, max(q.z, -q.z));
    }
};

}  // namespace kagero::hamiltonians

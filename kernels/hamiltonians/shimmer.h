#pragma once

#include "kernels/hamiltonians/hamiltonian.h"

namespace kagero::hamiltonians {

/// Heat shimmer: air whose index wavers at random, but fixed and smooth, from place to place.
///
///     H = ½ (|p|² − N²),  N = n0 (1 + amplitude · g),  g = √(2/M) Σ_j cos(k_j·x + φ_j)     after Satoh (2003), §4.1
///
/// Cartesian coordinates, H0 = 0. g is a sum of M = 12 plane waves whose wave vectors are drawn from a normal
/// distribution of width 1/correlation_length, so that <g(x) g(y)> ≈ exp(−|x − y|²/2L²) (Kraichnan 1970, eq. 2.10);
/// `seed` turns them and shifts their phases. The paper wants random air; only a function of position has a
/// Hamiltonian. Domain: all of space.
struct Shimmer : IndexMedium<Shimmer> {
    static constexpr const char* name = "shimmer";
    static constexpr const char* what = "air that wavers at random: heat shimmer";
    static constexpr const char* formula = "H = (|p|^2 - N^2)/2, N = n0 (1 + amplitude sum cos(k.x + phase))";
    static constexpr const char* source = "after Satoh (2003), sec. 4.1; Kraichnan (1970), eq. (2.10)";
    static constexpr const char* conserved = "none";
    static constexpr std::array parameters{
        ParameterInfo{"n0", 1.0, 0, unlimited, true, Unit::number, "mean index"},
        ParameterInfo{"amplitude", 0.01, 0, 0.15, false, Unit::number, "relative fluctuation, root mean square"},
        ParameterInfo{"correlation_length", 1.0, 0, unlimited, true, Unit::length, "L, over which the index changes"},
        ParameterInfo{"seed", 1, 0, 1e6, false, Unit::whole_number, "chooses the medium"},
    };
    static constexpr double step = 0.5;
    static constexpr const char* step_goes_with = "correlation_length";
    static constexpr const char* index_parameter = "n0";

    template <class V>
    struct Parameters {
        V n0, amplitude, correlation_length, seed;
    };

    /// Wave vectors in units of 1/L, and how fast each phase runs with the seed.
    struct Wave {
        double x, y, z, phase;
    };
    static constexpr int modes = 12;
    static constexpr std::array<Wave, modes> waves = [] {
        std::array<Wave, modes> w{};
        std::uint64_t state = 20030401;
        const auto uniform = [&state] {  // Knuth's linear congruential generator; its high bits
            state = state * 6364136223846793005u + 1442695040888963407u;
            return static_cast<double>(state >> 11) / 9007199254740992.0;
        };
        const auto normal = [&uniform] {  // Irwin and Hall: a sum of twelve has mean 6 and variance 1
            double sum = -6;
            for (int i = 0; i < 12; ++i) sum += uniform();
            return sum;
        };
        for (Wave& wave : w) wave = {normal(), normal(), normal(), 1 + 5 * uniform()};
        return w;
    }();

    template <class V>
    static constexpr V index_squared(const Parameters<V>& k, const Vec3<V>& q) {
        const V c = cos(k.seed), s = sin(k.seed), scale = 1.0 / k.correlation_length;
        const Vec3<V> turned{scale * c * q.x - scale * s * q.y, scale * s * q.x + scale * c * q.y, scale * q.z};
        V sum(0.0);
        for (const Wave& w : waves) {
            const V phase = atan2(sin(w.phase * k.seed), cos(w.phase * k.seed));  // within a turn, whatever the seed
            sum = sum + cos(w.x * turned.x + w.y * turned.y + w.z * turned.z + phase);
        }
        const V index = k.n0 + k.n0 * k.amplitude * 0.40824829046386302 * sum;  // sqrt(2/12)
        return index * index;
    }
};

}  // namespace kagero::hamiltonians

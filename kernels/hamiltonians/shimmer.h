#pragma once

#include "kernels/hamiltonians/hamiltonian.h"

namespace kagero::hamiltonians {

/// Heat shimmer: air whose index is a smooth random function of position.
///
///     H = ½ (|p|² − N²),  N = n0 (1 + amplitude · g),  g = √(2/M) Σ_j cos(k_j·x + φ_j)     after Satoh (2003), §4.1
///
/// Coordinates: Cartesian. Units: scene lengths; n0 and amplitude are numbers. Level: H0 = 0. Conserved: only H.
/// Domain: all of space.
///
/// g is a sum of M = 12 plane waves. The components of their wave vectors are normal random numbers with standard
/// deviation 1/L, where L is correlation_length, so that <g(x) g(y)> ≈ exp(−|x − y|²/2L²) (Kraichnan 1970, eq. 2.10).
/// `seed` rotates the wave vectors about z and shifts the phases. Satoh (2003) only states that n fluctuates at random;
/// a Hamiltonian requires a fixed function of position.
struct Shimmer : IndexMedium<Shimmer> {
    static constexpr const char* name = "shimmer";
    static constexpr const char* what = "air with a smooth random index: heat shimmer";
    static constexpr const char* formula = "H = (|p|^2 - N^2)/2, N = n0 (1 + amplitude sum cos(k.x + phase))";
    static constexpr const char* source = "after Satoh (2003), sec. 4.1; Kraichnan (1970), eq. (2.10)";
    static constexpr const char* conserved = "none";
    static constexpr std::array parameters{
        ParameterInfo{"n0", 1.0, 0, unlimited, true, Unit::number, "mean index"},
        ParameterInfo{"amplitude", 0.01, 0, 0.15, false, Unit::number, "relative fluctuation, root mean square"},
        ParameterInfo{"correlation_length", 1.0, 0, unlimited, true, Unit::length, "L, length of the fluctuations"},
        ParameterInfo{"seed", 1, 0, 1e6, false, Unit::whole_number, "selects the random function"},
    };
    static constexpr double step = 0.5;
    static constexpr const char* step_goes_with = "correlation_length";
    static constexpr const char* index_parameter = "n0";

    template <class V>
    struct Parameters {
        V n0, amplitude, correlation_length, seed;
    };

    /// A plane wave: the wave vector in units of 1/L, and the phase in radians per unit of `seed`.
    struct Wave {
        double x, y, z, phase;
    };
    static constexpr int modes = 12;
    static constexpr std::array<Wave, modes> waves = [] {
        std::array<Wave, modes> w{};
        std::uint64_t state = 20030401;
        const auto uniform = [&state] {  // the high bits of Knuth's linear congruential generator
            state = state * 6364136223846793005u + 1442695040888963407u;
            return static_cast<double>(state >> 11) / 9007199254740992.0;
        };
        const auto normal = [&uniform] {  // Irwin and Hall: a sum of twelve uniform numbers has mean 6 and variance 1
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
        // q/L, rotated about z by `seed` radians.
        const Vec3<V> rotated{scale * c * q.x - scale * s * q.y, scale * s * q.x + scale * c * q.y, scale * q.z};
        V sum(0.0);
        for (const Wave& w : waves) {
            const V phase = atan2(sin(w.phase * k.seed), cos(w.phase * k.seed));  // reduced to [−π, π] for every seed
            sum = sum + cos(w.x * rotated.x + w.y * rotated.y + w.z * rotated.z + phase);
        }
        const V index = k.n0 + k.n0 * k.amplitude * 0.40824829046386302 * sum;  // sqrt(2/12)
        return index * index;
    }
};

}  // namespace kagero::hamiltonians

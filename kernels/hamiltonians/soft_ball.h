#pragma once

#include "kernels/hamiltonians/hamiltonian.h"

namespace kagero::hamiltonians {

/// A ball of glass without an edge: N = 1 + strength · exp(−4 r²).
struct SoftBall : IndexMedium<SoftBall> {                    // in soft_ball.h
    static constexpr const char* name = "soft-ball";
    static constexpr const char* what = "a ball of glass without an edge";
    static constexpr const char* formula = "H = (|p|^2 - N^2)/2, N = 1 + strength exp(-4 r^2)";
    static constexpr const char* source = "docs/hamiltonians.md";
    static constexpr const char* conserved = "x cross p";
    static constexpr std::array parameters{
        ParameterInfo{"strength", 0.6, 0, unlimited, false, "1", "how much denser the middle is"},
    };
    static constexpr double step = 0.05;

    template <class V>
    struct Parameters {
        V strength;
    };

    template <class V>
    static constexpr V index_squared(const Parameters<V>& k, const Vec3<V>& q) {
        const V n = 1.0 + k.strength * exp(-4.0 * dot(q, q));
        return n * n;
    }
};

}  // namespace kagero::hamiltonians

#pragma once

#include "kernels/hamiltonians/hamiltonian.h"

namespace kagero::hamiltonians {

/// Hot air above the ground: a mirage.
///
///     H = ½ n |p|²                                       Satoh (2003), eq. (17)
///     n = n0 − n3 z³ + ripple · cos(wavenumber · x)      Satoh (2003), eq. (18)
///
/// Coordinates: Cartesian, z up. Units: scene lengths; n is a number. Level: H0 = ½. Conserved: H and p_y; also p_x if
/// ripple = 0. Domain: n > n_min; rays escape at its edge. With Satoh's parameters, n decreases to zero near z = 1.4.
///
/// n is not the refractive index. On H = H0, the rays are those of a medium with the refractive index N ∝ n^(−1/2). N
/// decreases towards the hot ground, so that rays bend upward.
struct Mirage {
    static constexpr const char* name = "mirage";
    static constexpr const char* what = "hot air above the ground";
    static constexpr const char* formula = "H = n |p|^2 / 2, n = n0 - n3 z^3 + ripple cos(wavenumber x)";
    static constexpr const char* source = "Satoh (2003), eqs. (17), (18)";
    static constexpr const char* conserved = "py";
    static constexpr std::array parameters{
        ParameterInfo{"n0", 0.85, 0, unlimited, true, Unit::number, "n at z = 0, without the ripple"},
        ParameterInfo{"n3", 0.3, -unlimited, unlimited, false, Unit::per_length_cubed, "coefficient of -z^3 in n"},
        ParameterInfo{"ripple", 0.03, -unlimited, unlimited, false, Unit::number, "amplitude of the ripple along x"},
        ParameterInfo{"wavenumber", 9.42477796076937971539, 0, unlimited, false, Unit::per_length,
                      "wavenumber of the ripple; 3 pi in Satoh (2003)"},
        ParameterInfo{"n_min", 0.05, 0, unlimited, true, Unit::number, "n at the edge of the medium"},
    };
    static constexpr bool spacetime = false;
    static constexpr double level = 0.5;
    static constexpr const char* method = "srkn6";
    static constexpr double step = 0.1;
    /// The length scale of the ripple, or the height over which n changes, whichever is shorter. For the default
    /// parameters, the two lengths are nearly equal.
    static constexpr const char* step_goes_with = "min(1/wavenumber, 0.075*(n0/abs(n3))^(1/3))";

    template <class V>
    struct Parameters {
        V n0, n3, ripple, wavenumber, n_min;
    };

    template <class V>
    static constexpr V n(const Parameters<V>& k, const Vec3<V>& q) {
        return k.n0 - k.n3 * (q.z * q.z * q.z) + k.ripple * cos(k.wavenumber * q.x);
    }

    template <class V>
    static constexpr V energy(const Parameters<V>& k, const Vec3<V>& q, const Vec3<V>& p, const V&) {
        return 0.5 * n(k, q) * dot(p, p);
    }

    /// Ω = 1/n: the rescaled Hamiltonian (H − ½)/n = ½ (|p|² − 1/n) is separable.
    template <class V>
    static constexpr V rescale(const Parameters<V>& k, const Vec3<V>& q) {
        return 1.0 / n(k, q);
    }

    template <class V>
    static constexpr V domain(const Parameters<V>& k, const Vec3<V>& q) {
        return n(k, q) - k.n_min;
    }

    /// Returns 0.2 n/G, where G is an upper bound of |∇n| for all x: n changes by at most about a fifth of its value in
    /// a step. Near the edge of the medium, n is small and rays are strongly curved, so that steps have to be short.
    /// The constant 1e-30 keeps the result finite where G = 0.
    template <class V>
    static constexpr V max_step_length(const Parameters<V>& k, const Vec3<V>& q) {
        const V max_gradient_x = k.ripple * k.wavenumber, gradient_z = 3.0 * k.n3 * (q.z * q.z);
        return 0.2 * max(n(k, q), k.n_min) / sqrt(max_gradient_x * max_gradient_x + gradient_z * gradient_z + 1e-30);
    }

    /// H_A contains the horizontal components of the momentum, H_B the vertical component.
    template <class V>
    static constexpr V part_a(const Parameters<V>& k, const Vec3<V>& q, const Vec3<V>& p, const V&) {
        return 0.5 * n(k, q) * (p.x * p.x + p.y * p.y);
    }
    template <class V>
    static constexpr V part_b(const Parameters<V>& k, const Vec3<V>& q, const Vec3<V>& p, const V&) {
        return 0.5 * n(k, q) * (p.z * p.z);
    }
};

}  // namespace kagero::hamiltonians

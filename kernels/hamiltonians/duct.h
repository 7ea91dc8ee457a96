#pragma once

#include "kernels/hamiltonians/hamiltonian.h"

namespace kagero::hamiltonians {

/// A duct of cool air between warm layers: the mirage of Satoh (2003), made symmetric in height.
///
///     H = ½ n |p|²                                          Satoh (2003), eq. (17)
///     n = n0 + n3 |z|³ + ripple · cos(wavenumber · x)       as eq. (18), with |z|³ instead of −z³
///
/// Coordinates: Cartesian, z up, z = 0 on the axis of the duct. Units: scene lengths; n is a number. Level: H0 = ½.
/// Domain: all of space; n > 0 if n0 > |ripple|. Conserved: H and p_y; also p_x if ripple = 0.
///
/// The refractive index N ∝ n^(−1/2) is greatest on the axis. Rays oscillate about the axis and never leave the duct,
/// so that the duct is suitable for tests of long integrations.
struct Duct {
    static constexpr const char* name = "duct";
    static constexpr const char* what = "duct of cool air between warm layers";
    static constexpr const char* formula = "H = n |p|^2 / 2, n = n0 + n3 |z|^3 + ripple cos(wavenumber x)";
    static constexpr const char* source = "after Satoh (2003), eqs. (17), (18)";
    static constexpr const char* conserved = "py";
    static constexpr std::array parameters{
        ParameterInfo{"n0", 0.85, 0, unlimited, true, Unit::number, "n on the axis, without the ripple"},
        ParameterInfo{"n3", 0.3, 0, unlimited, false, Unit::per_length_cubed, "coefficient of |z|^3 in n"},
        ParameterInfo{"ripple", 0.03, -unlimited, unlimited, false, Unit::number, "amplitude of the ripple along x"},
        ParameterInfo{"wavenumber", 9.42477796076937971539, 0, unlimited, false, Unit::per_length,
                      "wavenumber of the ripple; 3 pi in Satoh (2003)"},
    };
    static constexpr bool spacetime = false;
    static constexpr double level = 0.5;
    static constexpr const char* method = "srkn6";
    static constexpr double step = 0.2;
    /// The length scale of the ripple, or the height over which n changes, whichever is shorter. For the default
    /// parameters, the two lengths are nearly equal.
    static constexpr const char* step_goes_with = "min(1/wavenumber, 0.075*(n0/n3)^(1/3))";

    template <class V>
    struct Parameters {
        V n0, n3, ripple, wavenumber;
    };

    template <class V>
    static constexpr V n(const Parameters<V>& k, const Vec3<V>& q) {
        return k.n0 + k.n3 * (q.z * q.z * max(q.z, -q.z)) + k.ripple * cos(k.wavenumber * q.x);
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

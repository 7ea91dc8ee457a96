#pragma once

#include "kernels/hamiltonians/hamiltonian.h"

namespace kagero::hamiltonians {

/// A duct of cool air between warm layers: the paper's mirage made symmetric in height, so that rays stay in it for
/// ever.
///
///     H = ½ n |p|²                                          Satoh (2003), eq. (17)
///     n = n0 + n3 |z|³ + ripple · cos(wavenumber · x)       as eq. (18), with |z|³ for −z³
///
/// Cartesian coordinates, z up, z = 0 on the duct's axis; H0 = ½. The index N ∝ n^(−1/2) is greatest on the axis and
/// rays swing about it: the place to watch an integrator for a long time. Conserved: H and p_y; with ripple = 0 also
/// p_x.
///
/// Domain: all of space (n > 0 wherever n0 > |ripple|).
struct Duct {
    static constexpr const char* name = "duct";
    static constexpr const char* what = "duct of cool air between warm layers";
    static constexpr const char* formula = "H = n |p|^2 / 2, n = n0 + n3 |z|^3 + ripple cos(wavenumber x)";
    static constexpr const char* source = "after Satoh (2003), eqs. (17), (18)";
    static constexpr const char* conserved = "py";
    static constexpr std::array parameters{
        ParameterInfo{"n0", 0.85, 0, unlimited, true, Unit::number, "n on the axis, without the ripple"},
        ParameterInfo{"n3", 0.3, 0, unlimited, false, Unit::per_length_cubed, "how n changes with height"},
        ParameterInfo{"ripple", 0.03, -unlimited, unlimited, false, Unit::number, "amplitude of the ripple along x"},
        ParameterInfo{"wavenumber", 9.42477796076937971539, 0, unlimited, false, Unit::per_length,
                      "of the ripple; 3 pi in the paper"},
    };
    static constexpr bool spacetime = false;
    static constexpr double level = 0.5;
    static constexpr const char* method = "srkn6";
    static constexpr double step = 0.2;
    /// The ripple, or the height over which n changes, whichever is shorter; about alike with the numbers above.
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

    /// With 1/n the rescaled Hamiltonian (H − ½)/n = ½ (|p|² − 1/n) has the same rays and is separable.
    template <class V>
    static constexpr V rescale(const Parameters<V>& k, const Vec3<V>& q) {
        return 1.0 / n(k, q);
    }

    /// Separated by components of the momentum: along the ground, and upward.
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

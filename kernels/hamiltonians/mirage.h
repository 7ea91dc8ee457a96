#pragma once

#include "kernels/hamiltonians/hamiltonian.h"

namespace kagero::hamiltonians {

/// Hot air above the ground: the paper's mirage.
///
///     H = ½ n |p|²                                       Satoh (2003), eq. (17)
///     n = n0 − n3 z³ + ripple · cos(wavenumber · x)      Satoh (2003), eq. (18)
///
/// Cartesian coordinates, z up; H0 = ½. This n is not the refractive index: on a level set of H a ray is that of
/// the index N ∝ n^(−1/2), so N falls towards the hot ground and rays bend up. Conserved: H and p_y; with
/// ripple = 0 also p_x.
///
/// Domain: n > n_min. n falls to zero some way up (near z = 1.4 with the paper's numbers); a ray that gets there is
/// escaped.
struct Mirage {
    static constexpr const char* name = "mirage";
    static constexpr const char* what = "hot air above the ground";
    static constexpr const char* formula = "H = n |p|^2 / 2, n = n0 - n3 z^3 + ripple cos(wavenumber x)";
    static constexpr const char* source = "Satoh (2003), eqs. (17), (18)";
    static constexpr const char* conserved = "py";
    static constexpr std::array parameters{
        ParameterInfo{"n0", 0.85, 0, unlimited, true, Unit::number, "n at the camera's height, without the ripple"},
        ParameterInfo{"n3", 0.3, -unlimited, unlimited, false, Unit::per_length_cubed, "how n changes with height"},
        ParameterInfo{"ripple", 0.03, -unlimited, unlimited, false, Unit::number, "amplitude of the ripple along x"},
        ParameterInfo{"wavenumber", 9.42477796076937971539, 0, unlimited, false, Unit::per_length,
                      "of the ripple; 3 pi in the paper"},
        ParameterInfo{"n_min", 0.05, 0, unlimited, true, Unit::number, "where the medium ends"},
    };
    static constexpr bool spacetime = false;
    static constexpr double level = 0.5;
    static constexpr const char* method = "srkn6";
    static constexpr double step = 0.1;
    /// The ripple, or the height over which n changes, whichever is shorter; about alike with the numbers above.
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

    /// With 1/n the rescaled Hamiltonian (H − ½)/n = ½ (|p|² − 1/n) has the same rays and is separable.
    template <class V>
    static constexpr V rescale(const Parameters<V>& k, const Vec3<V>& q) {
        return 1.0 / n(k, q);
    }

    template <class V>
    static constexpr V domain(const Parameters<V>& k, const Vec3<V>& q) {
        return n(k, q) - k.n_min;
    }

    /// Towards the edge light turns as quickly as n falls: n changes there by a part of itself in a step. Where n does
    /// not change at all what is least keeps that finite.
    template <class V>
    static constexpr V max_step_length(const Parameters<V>& k, const Vec3<V>& q) {
        const V along = k.ripple * k.wavenumber, upward = 3.0 * k.n3 * (q.z * q.z);
        return 0.2 * max(n(k, q), k.n_min) / sqrt(along * along + upward * upward + 1e-30);
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

#pragma once

#include "kernels/hamiltonians/hamiltonian.h"

namespace kagero::hamiltonians {

/// A spherical black hole: the Schwarzschild spacetime in Cartesian Kerr–Schild coordinates, outgoing form.
///
///     H = ½ (|p|² − p_t²) − ½ (r_g/r) (p_t + x·p/r)²     Satoh (2003), eq. (16), as a perfect square
///
/// Coordinates: Cartesian Kerr–Schild x, y, z relative to the centre of the hole, r = |x|. Units: scene lengths;
/// r_g = 2GM/c². Level: H0 = 0, null rays. Conserved: H, p_t (H does not depend on time), x × p.
///
/// Domain: r > 0. A ray with p_t > 0 crosses the horizon r = r_g inward; near r = 0 it would turn outward again. It is
/// therefore captured at r ≤ r_g. No inward ray returns from inside the photon sphere r = 3/2 r_g (Chandrasekhar 1983,
/// §20), so it is already captured there. Scenes with surfaces inside the photon sphere reduce this radius
/// (Job::capture_radius).
struct Schwarzschild {
    static constexpr const char* name = "schwarzschild";
    static constexpr const char* what = "spherical black hole, Kerr-Schild coordinates";
    static constexpr const char* formula = "H = (|p|^2 - pt^2)/2 - (rg/r)/2 (pt + x.p/r)^2";
    static constexpr const char* source = "Satoh (2003), eq. (16)";
    static constexpr const char* conserved = "pt, x cross p";
    static constexpr std::array parameters{
        ParameterInfo{"rg", 1.0, 0.0, unlimited, false, Unit::length, "Schwarzschild radius 2GM/c^2"},
    };
    static constexpr bool spacetime = true;
    static constexpr double level = 0;
    static constexpr const char* method = "dp8";
    static constexpr double step = 0.3;

    template <class V>
    struct Parameters {
        V rg;
    };

    template <class V>
    static constexpr V energy(const Parameters<V>& k, const Vec3<V>& q, const Vec3<V>& p, const V& pt) {
        const V r = norm(q);
        const V u = pt + dot(q, p) / r;
        return 0.5 * (dot(p, p) - pt * pt) - 0.5 * (k.rg / r) * u * u;
    }

    /// H_A and H_B (Satoh 2003, eq. 10).
    template <class V>
    static constexpr V part_a(const Parameters<V>&, const Vec3<V>&, const Vec3<V>& p, const V& pt) {
        return 0.5 * (dot(p, p) - pt * pt);
    }
    template <class V>
    static constexpr V part_b(const Parameters<V>& k, const Vec3<V>& q, const Vec3<V>& p, const V& pt) {
        const V r = norm(q);
        const V u = pt + dot(q, p) / r;
        return -0.5 * (k.rg / r) * u * u;
    }

    /// Advances q and p by the exact flow of part_b; λ increases by t. With u = p_t + x·p/r, the flow conserves
    /// n = x/r, the angular momentum and w = u/√r, so that r^{3/2} is linear in λ: r_end = c^{2/3} with
    /// c = r^{3/2} − (3/2) r_g w t. The cube root of c is computed by Halley's iteration, which starts at √r.
    template <class V>
    static constexpr void remainder_flow(const Parameters<V>& k, Vec3<V>& q, Vec3<V>& p, const V& pt, const V& t) {
        const V r = norm(q), sqrt_r = sqrt(r);
        const Vec3<V> n = (V(1) / r) * q;
        const V pr = dot(n, p), w = (pt + pr) / sqrt_r;
        // c ≤ 0 means that the ray reaches the centre. With a small positive c the ray ends near the centre, where it
        // is captured.
        const V c = max(r * sqrt_r - V(1.5) * k.rg * w * t, V(1e-6) * r * sqrt_r);
        V s = sqrt_r;  // converges to the cube root of c
        for (int i = 0; i < 6; ++i) {
            const V cube = s * s * s;
            s = s * (cube + V(2) * c) / (V(2) * cube + c);
        }
        const V r_end = s * s;
        const V pr_end = w * s - pt;
        p = pr_end * n + (r / r_end) * (p - pr * n);
        q = r_end * n;
    }

    /// Ω = r, the length scale of H.
    template <class V>
    static constexpr V rescale(const Parameters<V>&, const Vec3<V>& q) {
        return norm(q);
    }

    /// Only rays with p_t > 0 are captured at the horizon. Rays with p_t < 0, which a falling observer sees, cross the
    /// horizon outward.
    template <class V>
    static constexpr V captured(const Parameters<V>& k, const Vec3<V>& q, const Vec3<V>&, const Vec3<V>& v,
                                const V& pt) {
        const V r = norm(q);
        const V inside_photon_sphere_and_inward = max(r - 1.5 * k.rg, dot(q, v));
        return min(max(r - k.rg, -pt), inside_photon_sphere_and_inward);
    }

    /// Near the horizon, light that moves outward has p ∝ 1/(r − r_g); the bound is a quarter of |r − r_g|. Farther out
    /// the bound grows with the cube of this distance, and it does not limit usual steps beyond r = 5/4 r_g. No step is
    /// longer than 0.9 r, so that none jumps over the hole. The bound is positive at the horizon, so that rays with p_t
    /// < 0 can cross the horizon.
    template <class V>
    static constexpr V max_step_length(const Parameters<V>& k, const Vec3<V>& q) {
        const V r = norm(q), distance = r - k.rg, d = max(max(distance, -distance), 1e-7 * k.rg), ratio = d / k.rg;
        return min(d * (0.25 + 40.0 * ratio * ratio), 0.9 * r);
    }

    /// V(u) follows from ½ (du/dφ)² + V = ½ p_t²/L² (Chandrasekhar 1983, §20, eq. 212).
    template <class V>
    static constexpr V orbit_potential(const Parameters<V>& k, const V& u, const V&) {
        return 0.5 * u * u - 0.5 * k.rg * u * u * u;
    }
    /// Returns p·x/r = U − p_t. U satisfies (1 − r_g u) U = p_t + v and (p_t − v) U = L² u². For some rays, one of
    /// these equations gives U = 0/0. Their sum with the weights a = max(p_t v, 0) and b = p_t never does.
    template <class V>
    static constexpr V radial_momentum(const Parameters<V>& k, const V& u, const V& v, const V& l, const V& pt) {
        const V a = max(pt * v, V(0)), b = pt, lu = l * u;
        return (a * (pt + v) + b * lu * lu) / (a * (V(1) - k.rg * u) + b * (pt - v)) - pt;
    }
    static constexpr const char* orbit_method = "orbit-srkn11";
    static constexpr double orbit_step = 0.3;

    /// For observers: the areal radius r.
    template <class V>
    static constexpr V radius(const Parameters<V>&, const Vec3<V>& q) {
        return norm(q);
    }
    /// For observers: dt_S = dt + time_offset_gradient dr, where t_S is the Schwarzschild time.
    template <class V>
    static constexpr V time_offset_gradient(const Parameters<V>& k, const V& r) {
        return k.rg / (r - k.rg);
    }
    /// For observers: −u_r, where u is the four-velocity of matter that falls from rest at infinity, in the ingoing
    /// form (t → −t); u_t = −1 (Martel & Poisson 2001).
    template <class V>
    static constexpr V infall(const Parameters<V>& k, const V& r) {
        const V speed = sqrt(k.rg / r);
        return speed / (1.0 + speed);
    }

    static constexpr Hole hole(const Parameters<double>& k) { return {0.5 * k.rg, 0}; }
    static constexpr bool straight(const Parameters<double>& k) { return k.rg == 0; }
};

}  // namespace kagero::hamiltonians

#pragma once

#include "kernels/hamiltonians/hamiltonian.h"

namespace kagero::hamiltonians {

/// A spherical black hole: Schwarzschild's spacetime in Cartesian Kerr–Schild coordinates, outgoing form.
///
///     H = ½ (|p|² − p_t²) − ½ (r_g/r) (p_t + x·p/r)²     Satoh (2003), eq. (16), as the perfect square it is
///
/// x in scene lengths from the hole's centre, r = |x|; r_g = 2GM/c². Light rays have H = 0. Time does not occur, so p_t
/// is constant along a ray. Conserved: H, p_t, x × p.
///
/// Domain: r > 0. With p_t > 0 a ray followed from the eye falls through r = r_g smoothly; run on to r → 0 it would be
/// thrown out again, so it ends `captured` at r ≤ r_g, or in pictures, where no surface lies further in, once it moves
/// inward inside the photon sphere r = 3/2 r_g, from where no light ray returns (Chandrasekhar 1983, §20).
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

    /// The paper's two parts, eq. (10).
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

    /// The exact flow of part_b for a time t. Along it n = x/r, the angular momentum and w = u/√r are constant, so
    /// r^{3/2} falls linearly: c = r^{3/2} − (3/2) r_g w t, r' = c^{2/3}. The cube root is Halley's iteration from √r.
    template <class V>
    static constexpr void remainder_flow(const Parameters<V>& k, Vec3<V>& q, Vec3<V>& p, const V& pt, const V& t) {
        const V r = norm(q), root = sqrt(r);
        const Vec3<V> n = (V(1) / r) * q;
        const V pr = dot(n, p), w = (pt + pr) / root;
        const V c = max(r * root - V(1.5) * k.rg * w * t, V(1e-6) * r * root);  // c ≤ 0 is the centre itself: captured
        V s = root;
        for (int i = 0; i < 6; ++i) {
            const V cube = s * s * s;
            s = s * (cube + V(2) * c) / (V(2) * cube + c);
        }
        const V now = s * s;
        const V along = w * s - pt;
        p = along * n + (r / now) * (p - pr * n);
        q = now * n;
    }

    /// The only scale a ray meets is its distance from the centre.
    template <class V>
    static constexpr V rescale(const Parameters<V>&, const Vec3<V>& q) {
        return norm(q);
    }

    /// The horizon counts for rays with p_t > 0 alone: with p_t < 0 (a falling observer's) they come out through it.
    template <class V>
    static constexpr V captured(const Parameters<V>& k, const Vec3<V>& q, const Vec3<V>&, const Vec3<V>& v,
                                const V& pt) {
        const V r = norm(q);
        const V inside_photon_sphere_and_inward = max(r - 1.5 * k.rg, dot(q, v));
        return min(max(r - k.rg, -pt), inside_photon_sphere_and_inward);
    }

    /// Light that leaves the horizon's neighbourhood has p ∝ 1/(r − r_g): steps are a quarter of that distance there.
    /// From r = 5/4 r_g on the bound is out of a sensible step's way, and keeps others from leaping over the hole; at
    /// the horizon itself enough is left for rays with p_t < 0 to come through.
    template <class V>
    static constexpr V max_step_length(const Parameters<V>& k, const Vec3<V>& q) {
        const V r = norm(q), away = r - k.rg, d = max(max(away, -away), 1e-7 * k.rg), share = d / k.rg;
        return min(d * (0.25 + 40.0 * share * share), 0.9 * r);
    }

    /// The plane of an orbit: du/dφ = w with ½ w² + V = ½ p_t²/L² (Chandrasekhar 1983, §20, eq. 212).
    template <class V>
    static constexpr V orbit_potential(const Parameters<V>& k, const V& u, const V&) {
        return 0.5 * u * u - 0.5 * k.rg * u * u * u;
    }
    /// With U = p_t + p·x/r, f = r_g u: (1 − f) U = p_t + v and (p_t − v) U = L² u². Either is 0/0 somewhere; weighed
    /// like this they are not.
    template <class V>
    static constexpr V radial_momentum(const Parameters<V>& k, const V& u, const V& v, const V& l, const V& pt) {
        const V a = max(pt * v, V(0)), b = pt, lu = l * u;
        return (a * (pt + v) + b * lu * lu) / (a * (V(1) - k.rg * u) + b * (pt - v)) - pt;
    }
    static constexpr const char* orbit_method = "orbit-srkn11";
    static constexpr double orbit_step = 0.3;

    /// For observers: the areal radius; dt_S = dt + lag dr leads to Schwarzschild's time; and in the ingoing form (t →
    /// −t) rain that falls from rest at infinity has u_t = −1, u_r = −infall (Martel & Poisson 2001).
    template <class V>
    static constexpr V radius(const Parameters<V>&, const Vec3<V>& q) {
        return norm(q);
    }
    template <class V>
    static constexpr V time_offset_gradient(const Parameters<V>& k, const V& r) {
        return k.rg / (r - k.rg);
    }
    template <class V>
    static constexpr V infall(const Parameters<V>& k, const V& r) {
        const V speed = sqrt(k.rg / r);
        return speed / (1.0 + speed);
    }

    static constexpr Hole hole(const Parameters<double>& k) { return {0.5 * k.rg, 0}; }
    static constexpr bool straight(const Parameters<double>& k) { return k.rg == 0; }
};

}  // namespace kagero::hamiltonians

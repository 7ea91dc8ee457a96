#pragma once

#include "kernels/hamiltonians/hamiltonian.h"

namespace kagero::hamiltonians {

/// A rotating black hole: the Kerr spacetime in Cartesian Kerr–Schild coordinates, outgoing form.
///
///     H = ½ (|p|² − p_t²) − ½ f (p_t + l·p)²              Kerr & Schild (1965); Visser (2007), eq. (32)
///     f = 2 M r³ / (r⁴ + a² z²),  l = ((r x − a y)/(r² + a²), (r y + a x)/(r² + a²), z/r),  a = spin · M
///     r⁴ − (|x|² − a²) r² − a² z² = 0
///
/// Coordinates: Cartesian Kerr–Schild x, y, z relative to the centre of the hole, spin along +z. r is the
/// Boyer–Lindquist radius; on the equator x² + y² = r² + a². Units: scene lengths; M = GM/c², and spin = a/M is a
/// number. Without spin, the space equals `schwarzschild` with r_g = 2M. Level: H0 = 0, null rays. Conserved: H, p_t,
/// x p_y − y p_x, Carter's constant.
///
/// Domain: outside the ring singularity r = 0, which no ray reaches. A ray with p_t > 0 is captured at the outer
/// horizon r₊ = M + √(M² − a²). A ray that moves inward inside r = 3M and cannot turn back is already captured there.
/// Scenes with surfaces inside this radius reduce it (Job::capture_radius). Rays are followed backward from the camera.
/// In a picture with the spin axis upward, the left edge of the shadow is the prograde edge, which is closer to the
/// centre of the hole.
struct Kerr {
    static constexpr const char* name = "kerr";
    static constexpr const char* what = "rotating black hole, Kerr-Schild coordinates";
    static constexpr const char* formula = "H = (|p|^2 - pt^2)/2 - f/2 (pt + l.p)^2, f = 2 M r^3/(r^4 + a^2 z^2)";
    static constexpr const char* source = "Kerr & Schild (1965); Visser (2007), eq. (32)";
    static constexpr const char* conserved = "pt, x py - y px, Carter's constant";
    static constexpr std::array parameters{
        ParameterInfo{"mass", 1.0, 0, unlimited, true, Unit::length, "GM/c^2, half the Schwarzschild radius"},
        ParameterInfo{"spin", 0.9, -1, 1, false, Unit::number, "spin a/M, along +z"},
    };
    static constexpr bool spacetime = true;
    static constexpr double level = 0;
    static constexpr const char* method = "rkf78";
    static constexpr double step = 0.25;
    static constexpr double tiny = 1e-30;  ///< Keeps denominators greater than 0.

    template <class V>
    struct Parameters {
        V mass, spin;
    };

    /// The Boyer–Lindquist radius r.
    template <class V>
    static constexpr V radius(const Parameters<V>& k, const Vec3<V>& q) {
        const V a2 = k.mass * k.mass * (k.spin * k.spin), b = dot(q, q) - a2;
        return sqrt(0.5 * (b + sqrt(b * b + 4.0 * a2 * (q.z * q.z))));
    }

    /// ½ f (p_t + l·p)², written as M/r / (1 + (a z/r²)²) (p_t + l·p)², whose factors do not overflow in large scenes.
    template <class V>
    static constexpr V bending_term(const Parameters<V>& k, const Vec3<V>& q, const Vec3<V>& p, const V& pt) {
        const V a = k.spin * k.mass, r = radius(k, q), inverse = 1.0 / r, cos_theta = q.z * inverse,
                a_cos_over_r = a * inverse * cos_theta;
        const V horizontal = (r * (q.x * p.x + q.y * p.y) + a * (q.x * p.y - q.y * p.x)) / (r * r + a * a);
        const V u = pt + horizontal + cos_theta * p.z;
        return k.mass * inverse / (1.0 + a_cos_over_r * a_cos_over_r) * (u * u);
    }

    template <class V>
    static constexpr V energy(const Parameters<V>& k, const Vec3<V>& q, const Vec3<V>& p, const V& pt) {
        return 0.5 * (dot(p, p) - pt * pt) - bending_term(k, q, p, pt);
    }
    /// H_A and H_B (Satoh 2003, eq. 10).
    template <class V>
    static constexpr V part_a(const Parameters<V>&, const Vec3<V>&, const Vec3<V>& p, const V& pt) {
        return 0.5 * (dot(p, p) - pt * pt);
    }
    template <class V>
    static constexpr V part_b(const Parameters<V>& k, const Vec3<V>& q, const Vec3<V>& p, const V& pt) {
        return -bending_term(k, q, p, pt);
    }

    /// Ω = r, the length scale of H.
    template <class V>
    static constexpr V rescale(const Parameters<V>& k, const Vec3<V>& q) {
        return radius(k, q);
    }

    /// Rays that can cross the horizon inward are captured there. Inside r = 3M an inward ray is captured if its radial
    /// potential (see radial_potential_bound) is positive down to the horizon; without spin this is true for every
    /// inward ray. dr/dλ has the sign of r² x·v + a² z v_z.
    template <class V>
    static constexpr V captured(const Parameters<V>& k, const Vec3<V>& q, const Vec3<V>& p, const Vec3<V>& v,
                                const V& pt) {
        const V r = radius(k, q), a = k.mass * k.spin;
        const V horizon = k.mass * (1.0 + sqrt(max(1.0 - k.spin * k.spin, V(0.0))));
        const V outward = r * r * dot(q, v) + a * a * (q.z * v.z);  // > 0 if the ray moves outward
        // > 0 if the ray can cross the horizon inward: (r₊² + a²) p_t + a L > 0, where r₊² + a² = 2 M r₊.
        const V crosses = pt + a * (q.x * p.y - q.y * p.x) / (2.0 * k.mass * horizon);
        // > 0 if the ray can turn back.
        const V can_turn_back = max(r - 3.0 * k.mass, -radial_potential_bound(k, q, p, pt));
        return min(max(r - horizon, -crosses), max(can_turn_back, outward));
    }
    /// Returns a number that is positive only if the radial potential R is positive everywhere between the horizon and
    /// q. R is zero at a turning point (Carter 1968), so that an inward ray then cannot turn back:
    ///
    ///     R = ((r² + a²) p_t + a L)² − Δ (Q + (L + a p_t)²) = (Σ dr/dλ)²
    ///
    /// L = x p_y − y p_x, Q is Carter's constant, Δ = r² − 2Mr + a², and Σ = r² + a² cos²θ. Let ρ be the radius divided
    /// by r at q. Then R divided by r⁴ at q is
    ///
    ///     p_t² ρ⁴ − A ρ² + 2 B ρ − C,   A = (L² + Q − a² p_t²)/r², B = M ((L + a p_t)² + Q)/r³, C = a² Q/r⁴
    ///
    /// For ρ² ≥ A/(6 p_t²) this polynomial is convex and lies above its tangents. Two tangents are used: at ρ = 1, and
    /// at the minimum, which Newton's method approaches from greater ρ. The result is the greater of their values at
    /// the least ρ of the convex part. For smaller ρ the polynomial is concave, and at the horizon it is a square. If
    /// the result is positive, the polynomial is therefore also positive down to the horizon. In the code, all lengths
    /// are in units of r at q.
    template <class V>
    static constexpr V radial_potential_bound(const Parameters<V>& k, const Vec3<V>& q, const Vec3<V>& p, const V& pt) {
        const V r = radius(k, q), inverse = 1.0 / r, a = k.mass * k.spin * inverse, a2 = a * a, pt2 = pt * pt;
        const Vec3<V> n = inverse * q;
        const V horizontal = n.x * p.x + n.y * p.y, l = n.x * p.y - n.y * p.x, one_plus_a2 = 1.0 + a2;
        const V carter = n.z * n.z * (one_plus_a2 * (p.x * p.x + p.y * p.y) - a2 * pt2) -
                         2.0 * n.z * p.z * horizontal + (n.x * n.x + n.y * n.y) * (p.z * p.z) / one_plus_a2;
        const V l_plus_a_pt = l + a * pt;
        const V A = l * l + carter - a2 * pt2, B = k.mass * inverse * (l_plus_a_pt * l_plus_a_pt + carter),
                C = a2 * carter;
        const V horizon = k.mass * (1.0 + sqrt(max(1.0 - k.spin * k.spin, V(0.0)))) * inverse;
        return radial_polynomial_bound(A, B, C, pt2, horizon);
    }
    /// Returns the bound for the polynomial p_t² ρ⁴ − A ρ² + 2 B ρ − C, where `horizon` is r₊ in units of r at q.
    template <class V>
    static constexpr V radial_polynomial_bound(const V& A, const V& B, const V& C, const V& pt2, const V& horizon) {
        const V convex_from = min(max(horizon, sqrt(max(A, V(0.0)) / (6.0 * pt2 + tiny))), V(1.0));
        const auto slope = [&](const V& rho) { return 4.0 * pt2 * (rho * rho * rho) - 2.0 * A * rho + 2.0 * B; };
        // Returns the value at convex_from of the tangent at rho: the least value of the tangent if its slope is ≥ 0.
        // The slope can be negative only at rho = 1. The polynomial then decreases up to ρ = 1, where it is a square.
        const auto tangent_value = [&](const V& rho) {
            const V rho2 = rho * rho;
            return pt2 * (rho2 * rho2) - A * rho2 + 2.0 * B * rho - C - slope(rho) * (rho - convex_from);
        };
        V rho(1.0);
        for (int i = 0; i < 4; ++i)
            rho = min(max(rho - slope(rho) / max(12.0 * pt2 * (rho * rho) - 2.0 * A, V(tiny)), convex_from), V(1.0));
        return max(tangent_value(V(1.0)), tangent_value(rho));
    }

    /// Returns the smaller of two bounds. Near the horizon, light that moves outward has p ∝ 1/(r − r₊); the first
    /// bound is a fifth of |r − r₊| there. Farther out it grows with the cube of this distance. The second bound is
    /// ½ Σ/(r + |a|) with Σ = r² + a² cos²θ: about the distance from the ring singularity near the ring, and about r/2
    /// far from the hole. The second bound is the smaller one deep inside the horizon, and beyond r ≈ 2 r₊.
    template <class V>
    static constexpr V max_step_length(const Parameters<V>& k, const Vec3<V>& q) {
        const V r = radius(k, q), s2 = k.spin * k.spin, a = k.mass * sqrt(s2), az = a * q.z;
        const V horizon = k.mass * (1.0 + sqrt(max(1.0 - s2, V(0.0)))), distance = r - horizon;
        const V d = max(max(distance, -distance), 1e-7 * horizon), ratio = d / horizon;
        const V twice_ring_distance = (r * r + az * az / (r * r)) / (r + a);
        return min(d * (0.2 + ratio * ratio), 0.5 * twice_ring_distance);
    }

    /// For observers (see schwarzschild.h): dt_BL = dt + time_offset_gradient dr, where t_BL is the Boyer–Lindquist
    /// time. The gradient is 2Mr/Δ with Δ = r² − 2Mr + a².
    template <class V>
    static constexpr V time_offset_gradient(const Parameters<V>& k, const V& r) {
        const V a = k.spin * k.mass, two_mr = 2.0 * k.mass * r;
        return two_mr / (r * r + a * a - two_mr);
    }
    /// For observers: −u_r of matter that falls from rest at infinity without angular momentum (Doran 2000),
    /// √(2Mr)/(√(2Mr) + √(r² + a²)).
    template <class V>
    static constexpr V infall(const Parameters<V>& k, const V& r) {
        const V a = k.spin * k.mass, sqrt_2mr = sqrt(2.0 * k.mass * r);
        return sqrt_2mr / (sqrt_2mr + sqrt(r * r + a * a));
    }

    /// The motion separates in Mino time (Carter 1968; kernels/orbits/separated_motion.h).
    template <class V>
    static constexpr MassAndSpin<V> separated_hole(const Parameters<V>& k) {
        return {k.mass, k.mass * k.spin};
    }
    static constexpr const char* orbit_method = "mino-srkn11";
    static constexpr double orbit_step = 0.3;

    static constexpr Hole hole(const Parameters<double>& k) { return {k.mass, k.mass * k.spin}; }
};

}  // namespace kagero::hamiltonians

#pragma once

#include "kernels/hamiltonians/hamiltonian.h"

namespace kagero::hamiltonians {

/// A rotating black hole: Kerr's spacetime in Cartesian Kerr–Schild coordinates, outgoing form.
///
///     H = ½ (|p|² − p_t²) − ½ f (p_t + l·p)²              Kerr & Schild (1965); Visser (2007), eq. (32)
///     f = 2 M r³ / (r⁴ + a² z²),  l = ((r x − a y)/(r² + a²), (r y + a x)/(r² + a²), z/r),  a = spin · M
///     r⁴ − (|x|² − a²) r² − a² z² = 0
///
/// x in scene lengths from the hole's centre, spin along +z; M = GM/c², so the hole without spin is `schwarzschild`
/// with r_g = 2M. r is Boyer and Lindquist's radius: on the equator x² + y² = r² + a². Light rays have H = 0.
/// Conserved: H, p_t, x p_y − y p_x, and Carter's constant. Rays are followed backward from the eye, so with the spin
/// up the left edge of the shadow is the near, prograde one.
///
/// Domain: outside the ring r = 0, which no ray meets: one with p_t > 0 ends `captured` at the outer horizon r₊ = M +
/// √(M² − a²), or in pictures, where no surface lies further in, once it moves inward inside r = 3M from where nothing
/// turns it back.
struct Kerr {
    static constexpr const char* name = "kerr";
    static constexpr const char* what = "rotating black hole, Kerr-Schild coordinates";
    static constexpr const char* formula = "H = (|p|^2 - pt^2)/2 - f/2 (pt + l.p)^2, f = 2 M r^3/(r^4 + a^2 z^2)";
    static constexpr const char* source = "Kerr & Schild (1965); Visser (2007), eq. (32)";
    static constexpr const char* conserved = "pt, x py - y px, Carter's constant";
    static constexpr std::array parameters{
        ParameterInfo{"mass", 1.0, 0, unlimited, true, Unit::length, "GM/c^2, half the Schwarzschild radius"},
        ParameterInfo{"spin", 0.9, -1, 1, false, Unit::number, "a/M, along +z", true},
    };
    static constexpr bool spacetime = true;
    static constexpr double level = 0;
    static constexpr const char* method = "rkf78";
    static constexpr double step = 0.25;
    static constexpr double tiny = 1e-30;  ///< instead of zero below a fraction

    template <class V>
    struct Parameters {
        V mass, spin;
    };

    template <class V>
    static constexpr V radius(const Parameters<V>& k, const Vec3<V>& q) {
        const V a2 = k.mass * k.mass * (k.spin * k.spin), b = dot(q, q) - a2;
        return sqrt(0.5 * (b + sqrt(b * b + 4.0 * a2 * (q.z * q.z))));
    }

    /// ½ f (p_t + l·p)², the part that bends; f = 2 (M/r)/(1 + (a z/r²)²), of numbers near 1 at any size of the scene.
    template <class V>
    static constexpr V pull(const Parameters<V>& k, const Vec3<V>& q, const Vec3<V>& p, const V& pt) {
        const V a = k.spin * k.mass, r = radius(k, q), inverse = 1.0 / r, tilt = q.z * inverse,
                ring = a * inverse * tilt;
        const V across = (r * (q.x * p.x + q.y * p.y) + a * (q.x * p.y - q.y * p.x)) / (r * r + a * a);
        const V u = pt + across + tilt * p.z;
        return k.mass * inverse / (1.0 + ring * ring) * (u * u);
    }

    template <class V>
    static constexpr V energy(const Parameters<V>& k, const Vec3<V>& q, const Vec3<V>& p, const V& pt) {
        return 0.5 * (dot(p, p) - pt * pt) - pull(k, q, p, pt);
    }
    /// The paper's two parts, eq. (10).
    template <class V>
    static constexpr V part_a(const Parameters<V>&, const Vec3<V>&, const Vec3<V>& p, const V& pt) {
        return 0.5 * (dot(p, p) - pt * pt);
    }
    template <class V>
    static constexpr V part_b(const Parameters<V>& k, const Vec3<V>& q, const Vec3<V>& p, const V& pt) {
        return -pull(k, q, p, pt);
    }

    template <class V>
    static constexpr V rescale(const Parameters<V>& k, const Vec3<V>& q) {
        return radius(k, q);
    }

    /// As for `schwarzschild`; dr/dλ has the sign of r² x·v + a² z v_z. Without spin no ray turns back from within 3M.
    template <class V>
    static constexpr V captured(const Parameters<V>& k, const Vec3<V>& q, const Vec3<V>& p, const Vec3<V>& v,
                                const V& pt) {
        const V r = radius(k, q), a = k.mass * k.spin;
        const V horizon = k.mass * (1.0 + sqrt(max(1.0 - k.spin * k.spin, V(0.0))));
        const V outward = r * r * dot(q, v) + a * a * (q.z * v.z),
                within = max(r - 3.0 * k.mass, -least_potential(k, q, p, pt));
        return min(max(r - horizon, -pt), max(within, outward));
    }
    /// No more than the radial potential of Carter (1968), R = ((r² + a²) p_t + a L)² − Δ (Q + (L + a p_t)²) = (Σ
    /// dr/dλ)², is anywhere between the horizon and here, in r⁴: a ray turns back where it is zero. With ρ = (r
    /// there)/(r here) it is
    ///
    ///     p_t² ρ⁴ − A ρ² + 2 B ρ − C,   A = (L² + Q − a² p_t²)/r², B = M ((L + a p_t)² + Q)/r³, C = a² Q/r⁴
    ///
    /// and cannot fall below its ends where it curves down. Where it curves up, it lies above its tangents: those at ρ
    /// = 1, and at where Newton's method, which comes from above, seeks its lowest place.
    template <class V>
    static constexpr V least_potential(const Parameters<V>& k, const Vec3<V>& q, const Vec3<V>& p, const V& pt) {
        const V r = radius(k, q), inverse = 1.0 / r, spin = k.mass * k.spin * inverse, spin2 = spin * spin,
                pt2 = pt * pt;
        const Vec3<V> n = inverse * q;
        const V along = n.x * p.x + n.y * p.y, l = n.x * p.y - n.y * p.x, ring = 1.0 + spin2;
        const V carter = n.z * n.z * (ring * (p.x * p.x + p.y * p.y) - spin2 * pt2) - 2.0 * n.z * p.z * along +
                         (n.x * n.x + n.y * n.y) * (p.z * p.z) / ring;
        const V dragged = l + spin * pt;
        const V A = l * l + carter - spin2 * pt2, B = k.mass * inverse * (dragged * dragged + carter),
                C = spin2 * carter;
        const V horizon = k.mass * (1.0 + sqrt(max(1.0 - k.spin * k.spin, V(0.0)))) * inverse;
        const V lowest = min(max(horizon, sqrt(max(A, V(0.0)) / (6.0 * pt2 + tiny))), V(1.0));
        const auto slope = [&](const V& rho) { return 4.0 * pt2 * (rho * rho * rho) - 2.0 * A * rho + 2.0 * B; };
        const auto above = [&](const V& rho) {
            const V rho2 = rho * rho;
            return pt2 * (rho2 * rho2) - A * rho2 + 2.0 * B * rho - C - slope(rho) * (rho - lowest);
        };
        V rho(1.0);
        for (int i = 0; i < 4; ++i)
            rho = min(max(rho - slope(rho) / max(12.0 * pt2 * (rho * rho) - 2.0 * A, V(tiny)), lowest), V(1.0));
        return max(above(V(1.0)), above(rho));
    }

    /// As for `schwarzschild`, light that leaves the horizon's neighbourhood has p ∝ 1/(r − r₊): steps are a fifth of
    /// that distance there. From r = 2 r₊ on the bound is out of a sensible step's way. Inside the horizon it is half
    /// of Σ/(r + |a|), Σ = r² + a² cos²θ: the distance from the ring, near it.
    template <class V>
    static constexpr V max_step_length(const Parameters<V>& k, const Vec3<V>& q) {
        const V r = radius(k, q), s2 = k.spin * k.spin, a = k.mass * sqrt(s2), az = a * q.z;
        const V horizon = k.mass * (1.0 + sqrt(max(1.0 - s2, V(0.0)))), away = r - horizon;
        const V d = max(max(away, -away), 1e-7 * horizon), share = d / horizon;
        const V from_ring = (r * r + az * az / (r * r)) / (r + a);
        return min(d * (0.2 + share * share), 0.5 * from_ring);
    }

    /// For observers, as in `schwarzschild`: with Δ = r² − 2Mr + a², lag = 2Mr/Δ to Boyer and Lindquist's time, and
    /// rain without angular momentum (Doran 2000) has u_r = −√(2Mr)/(√(2Mr) + √(r² + a²)).
    template <class V>
    static constexpr V time_offset_gradient(const Parameters<V>& k, const V& r) {
        const V a = k.spin * k.mass, pull = 2.0 * k.mass * r;
        return pull / (r * r + a * a - pull);
    }
    template <class V>
    static constexpr V infall(const Parameters<V>& k, const V& r) {
        const V a = k.spin * k.mass, pull = sqrt(2.0 * k.mass * r);
        return pull / (pull + sqrt(r * r + a * a));
    }

    static constexpr Hole hole(const Parameters<double>& k) { return {k.mass, k.mass * k.spin}; }
};

}  // namespace kagero::hamiltonians

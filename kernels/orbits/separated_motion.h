/// The separated motion of light around a spinning black hole (Carter 1968), in Mino time τ with dτ = dλ/Σ (Mino 2003):
/// the radius and the direction from the centre move independently of each other.
///
/// With w = 1/r, the unit vector n = (sin θ cos φ, sin θ sin φ, cos θ) and Λ = Q + L²,
///
///     (dw/dτ)² = P(w) = p_t² − A w² + 2 B w³ − C w⁴,   A = Λ − a² p_t²,  B = M (Q + (L + a p_t)²),  C = a² Q
///     d²n/dτ² = a² p_t² n_z e_z − (Λ + 2 a² p_t² n_z²) n
///
/// L = x p_y − y p_x, and Q is Carter's constant. Both equations are of second order with polynomial right-hand sides.
/// They are regular at turning points and on the axis, and their accelerations depend on positions alone, so that
/// Nyström methods apply. The components of dn/dτ are p_θ and L/sin θ. The vector n follows from them, except for a
/// rotation about the axis by the angle ψ, which is an integral over the radial motion:
///
///     dψ/dτ = −a w (2 M p_t + a L w)/D + (a/D) dw/dτ,   D = Δ/r² = 1 − 2 M w + a² w²
///
/// The first term is regular outside the horizon. The integral of the second term is known. For rays that approach the
/// horizon in the direction in which they are regular (kernels/observers/charts.h), the sum is written without D:
///
///     dψ/dτ = a p_t − a (Q + (L + a p_t)²) w²/(W + dw/dτ),   W = p_t (1 + a² w²) + a L w²
#pragma once

#include "kernels/equations/recording.h"
#include "kernels/integrators/stepper_state.h"

namespace kagero {

/// Indices of the data of the separated motion in RayState::stepper_memory: w, dw/dτ, n and dn/dτ. The azimuth of n is
/// that of the coordinates. These data are more accurate than the position and momentum of the state.
enum SeparatedMemory {
    separated_w,
    separated_w_rate,
    separated_n,
    separated_n_rate = separated_n + 3,
    separated_memory_size = separated_n_rate + 3
};
static_assert(separated_memory_size <= stepper_memory_size);

/// H declares the hole around which the motion separates.
template <class H>
concept HasSeparatedMotion =
    requires(const typename H::template Parameters<double>& k) { H::separated_hole(k); };

/// The hole around which the motion separates.
template <class V>
struct SeparatedHole {
    V twice_mass, a, a2, horizon;  ///< 2M, the spin a = J/M, a², and r₊
    V gap;                         ///< r₊ − r₋

    template <class System>
    KAGERO_INLINE explicit SeparatedHole(const System& system) {
        using S = ScalarOf<V>;
        const auto hole = System::Hamiltonian::separated_hole(system.template parameters<V>());
        a = hole.spin;
        a2 = a * a;
        twice_mass = V(S(2)) * hole.mass;
        gap = V(S(2)) * sqrt(max(hole.mass * hole.mass - a2, V(S(0))));
        horizon = V(S(0.5)) * (twice_mass + gap);
    }
    /// Returns D = Δ/r².
    KAGERO_INLINE V delta(const V& w) const { return fma(w, fms(a2, w, twice_mass), V(ScalarOf<V>(1))); }
    /// Returns the integral of (a/D) dw from w = `from` to w = `to`. It is the logarithm of (1 + y)/(1 − y) times
    /// a/(r₊ − r₋), where y is proportional to r₊ − r₋.
    KAGERO_INLINE V azimuth_between(const V& from, const V& to) const {
        using S = ScalarOf<V>;
        const V one(S(1)), from_horizon = fnma(horizon, from, one), to_horizon = fnma(horizon, to, one);
        // With x = w/(1 − r₊ w): y = (r₊ − r₋) (x₁ − x₀)/(2 + (r₊ − r₋)(x₁ + x₀)), multiplied by both denominators.
        const V product = from_horizon * to_horizon,
                sum = fma(gap, fma(to, from_horizon, from * to_horizon), product + product);
        const V over_gap = (to - from) / sum, y = gap * over_gap, y2 = y * y;
        V series(S(1.0 / 15));
        for (int k = 13; k > 0; k -= 2) series = fma(series, y2, V(S(1.0 / k)));
        const MaskOf<V> is_large = y2 > V(S(0.01));
        if (any(is_large)) {
            const V safe = select(is_large, y, V(S(0.5)));
            series = select(is_large, V(S(0.5)) * log((one + safe) / (one - safe)) / safe, series);
        }
        return V(S(2)) * a * over_gap * series;
    }
};

/// The motion of w.
template <class V>
struct RadialMotion {
    /// True if w and dw/dτ are summed with compensation.
    static constexpr bool compensated = std::is_same_v<ScalarOf<V>, float>;
    V w, rate;                      ///< w and dw/dτ
    V w_rounding, rate_rounding;    ///< rounding errors of w and dw/dτ, for compensated summation
    V azimuth;                      ///< ψ without the known integral from `known_from` to w
    V known_from;                   ///< value of w from which the known integral is taken
    V squared_radius_integral;      ///< integral of r² over τ, if λ is requested

    /// Copies the given lanes of `next`.
    KAGERO_INLINE void copy_lanes(const RadialMotion& next, const MaskOf<V>& lanes, bool with_parameter) {
        w = select(lanes, next.w, w);
        rate = select(lanes, next.rate, rate);
        azimuth = select(lanes, next.azimuth, azimuth);
        known_from = select(lanes, next.known_from, known_from);
        if constexpr (compensated) {
            w_rounding = select(lanes, next.w_rounding, w_rounding);
            rate_rounding = select(lanes, next.rate_rounding, rate_rounding);
        }
        if (with_parameter)
            squared_radius_integral = select(lanes, next.squared_radius_integral, squared_radius_integral);
    }
};

/// The motion of n.
template <class V>
struct AngularMotion {
    Vec3<V> n, rate;             ///< n and dn/dτ
    V squared_height_integral;   ///< integral of n_z² over τ, if λ is requested
};

/// The constants of a ray: the hole, the constants of the motion, and products of them.
template <class V>
struct SeparatedConstants {
    using S = ScalarOf<V>;
    SeparatedHole<V> hole;
    V pt, angular_momentum;  ///< p_t, L
    V lambda;                ///< Λ = Q + L²
    V spin_energy;           ///< a² p_t²
    V carter;                ///< Q + (L + a p_t)²
    V A, three_b, twice_c;   ///< A, 3 B and 2 C of P(w)
    V scale;                 ///< √(Λ + 2 a² p_t²): a step of h radians is h/scale in τ; |q × p| without spin

    template <class System>
    KAGERO_INLINE SeparatedConstants(const System& system, const V& p_t, const AngularMotion<V>& m)
        : hole(system), pt(p_t) {
        const V a_pt = hole.a * pt;
        spin_energy = a_pt * a_pt;
        angular_momentum = m.n.x * m.rate.y - m.n.y * m.rate.x;
        lambda = dot(m.rate, m.rate) - spin_energy * (m.n.z * m.n.z);
        A = lambda - spin_energy;
        carter = max(lambda + spin_energy + V(S(2)) * angular_momentum * a_pt, V(S(0)));
        three_b = V(S(1.5)) * hole.twice_mass * carter;
        twice_c = V(S(2)) * hole.a2 * (lambda - angular_momentum * angular_momentum);
        scale = sqrt(max(lambda + V(S(2)) * spin_energy, V(std::numeric_limits<float>::min())));
    }
    /// Returns −d²w/dτ².
    KAGERO_INLINE V slope(const V& w) const { return w * fnma(w, fnma(twice_c, w, three_b), A); }
    /// Returns P(w) − p_t².
    KAGERO_INLINE V radial_term(const V& w) const {
        const V w2 = w * w, cubic = fnma(V(S(0.5)) * twice_c, w, V(S(2.0 / 3)) * three_b);
        return w2 * fms(w, cubic, A);
    }
    /// Returns W = p_t (1 + a² w²) + a L w².
    KAGERO_INLINE V weight(const V& w) const {
        return fma(w * w, fma(hole.a2, pt, hole.a * angular_momentum), pt);
    }
    /// Returns p_t + l·p = Δ⁻¹ (dr/dτ + (r² + a²) p_t + a L), where l is the principal null direction of H.
    KAGERO_INLINE V null_component(const V& w, const V& rate) const {
        const V sum = weight(w);
        const MaskOf<V> is_regular = sum * rate > V(S(0));
        return select(is_regular, carter * (w * w), sum - rate) / select(is_regular, sum + rate, hole.delta(w));
    }
    /// Returns the part of dψ/dτ that has no known integral.
    KAGERO_INLINE V azimuth_rate(const V& w) const {
        return -(hole.a * w * fma(hole.a * angular_momentum, w, hole.twice_mass * pt)) * recip(hole.delta(w));
    }
    /// Returns dψ/dτ of rays that approach the horizon in the direction in which they are regular.
    KAGERO_INLINE V regular_azimuth_rate(const V& w) const {
        const V sum = weight(w), size = sqrt(max(fma(pt, pt, radial_term(w)), V(S(0)))),
                rate = select(sum > V(S(0)), size, -size);
        return hole.a * (pt - carter * (w * w) / (sum + rate));
    }
    /// Returns the lanes in which `regular_azimuth_rate` is accurate over the next step: close to the horizon, where
    /// the ray does not turn back.
    KAGERO_INLINE MaskOf<V> uses_regular_rate(const V& w, const V& rate) const {
        const V sum = weight(w);
        return (hole.delta(w) < V(S(0.3))) & (sum * rate > V(S(0))) & (rate * rate > V(S(0.5)) * (sum * sum));
    }
};

}  // namespace kagero

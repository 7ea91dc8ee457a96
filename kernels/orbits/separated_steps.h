/// Steps of a Nyström method for the separated motion (separated_motion.h).
///
/// Each kick of w also adds the rate of the azimuth ψ. The integral of r² over τ, which λ needs, is
///
///     c ∫ dτ/w² = −[w'/w] + ∫ ((c − p_t²)/w² + B w − C w²) dτ        for every constant c
///
/// The code uses the greater of c = p_t² and c = ¼ (w² A + w'²) at the start of the step, as for orbits (orbit.h).
#pragma once

#include "kernels/integrators/composition.h"
#include "kernels/orbits/separated_motion.h"

namespace kagero {

/// Functions that advance the separated motion.
struct SeparatedSteps {
    /// Returns the number of kicks of w, or of n, in one step.
    template <class V>
    static V gradients_per_step(const Coefficients& coefficients) {
        return V(ScalarOf<V>((coefficients.fractions.size() + coefficients.kick_first) / 2));
    }

    /// Advances w by the length tau, and adds to ψ and to the integral of r².
    template <class V>
    KAGERO_INLINE static void advance_radius(const SeparatedConstants<V>& c, const Coefficients& coefficients,
                                             const V& tau, RadialMotion<V>& m, bool with_parameter) {
        const MaskOf<V> regular = c.uses_regular_rate(m.w, m.rate);
        if (with_parameter) {
            advance_radius_as<true, true>(c, coefficients, tau, m, regular);
        } else if (any(regular)) {
            advance_radius_as<true, false>(c, coefficients, tau, m, regular);
        } else {
            advance_radius_as<false, false>(c, coefficients, tau, m, regular);
        }
    }
    /// `near_horizon` is false if the mask `regular` is empty.
    template <bool near_horizon, bool with_parameter, class V>
    KAGERO_INLINE static void advance_radius_as(const SeparatedConstants<V>& c, const Coefficients& coefficients,
                                                const V& tau, RadialMotion<V>& m, const MaskOf<V>& regular) {
        using S = ScalarOf<V>;
        constexpr bool compensated = RadialMotion<V>::compensated;
        const V first_order = tau * m.rate, square = tau * tau, w_start = m.w, pt2 = c.pt * c.pt;
        V slope_sum(S(0)), azimuth_sum(S(0)), w_change = m.w_rounding;
        V divisor(S(0)), rate_over_w(S(0)), integral(S(0));  // for the integral of r²
        if constexpr (with_parameter) {
            divisor = max(pt2, V(S(0.25)) * fma(m.rate, m.rate, m.w * m.w * max(c.A, V(S(0)))));
            rate_over_w = m.rate * recip(m.w);
        }
        const auto kick = [&](double fraction) __attribute__((always_inline)) {
            const V weight{S(fraction)};
            slope_sum = fma(weight, c.slope(m.w), slope_sum);
            V turn = c.azimuth_rate(m.w);
            if constexpr (near_horizon) turn = select(regular, c.regular_azimuth_rate(m.w), turn);
            azimuth_sum = fma(weight, turn, azimuth_sum);
            if constexpr (with_parameter) {
                const V u = m.w, cubic = u * (V(S(1.0 / 3)) * c.three_b - V(S(0.5)) * c.twice_c * u);
                integral = fma(weight, fma(divisor - pt2, recip(u * u), cubic), integral);
            }
        };
        const auto drift = [&](double fraction) __attribute__((always_inline)) {
            const V weight{S(fraction)}, increment = fnma(square, slope_sum, first_order);
            if constexpr (compensated) {
                w_change = fma(weight, increment, w_change);
                m.w = w_start + w_change;
            } else {
                m.w = fma(weight, increment, m.w);
            }
        };
        apply_fractions(coefficients, kick, drift);
        if constexpr (compensated) {
            const V rate_change = fnma(tau, slope_sum, m.rate_rounding), rate_start = m.rate;
            m.rate = rate_start + rate_change;
            m.w_rounding = w_change - (m.w - w_start);
            m.rate_rounding = rate_change - (m.rate - rate_start);
        } else {
            m.rate = fnma(tau, slope_sum, m.rate);
        }
        if constexpr (near_horizon) {
            if (any(regular)) {
                const V known = c.hole.azimuth_between(m.known_from, w_start);
                m.azimuth = select(regular, m.azimuth + known, m.azimuth);
                m.known_from = select(regular, m.w, m.known_from);
            }
        }
        m.azimuth = fma(tau, azimuth_sum, m.azimuth);
        if constexpr (with_parameter)
            m.squared_radius_integral += fma(tau, integral, rate_over_w - m.rate * recip(m.w)) * recip(divisor);
    }
    /// Advances n by the length tau, and adds to the integral of n_z².
    template <class V>
    KAGERO_INLINE static void advance_direction(const SeparatedConstants<V>& c, const Coefficients& coefficients,
                                                const V& tau, AngularMotion<V>& m, bool with_parameter) {
        using S = ScalarOf<V>;
        const V twice_spin_energy = V(S(2)) * c.spin_energy;
        const auto kick = [&](double fraction) __attribute__((always_inline)) {
            const V t = tau * V(S(fraction)), z2 = m.n.z * m.n.z, slope = fma(twice_spin_energy, z2, c.lambda);
            const V change = t * slope;
            m.rate.x = fnma(change, m.n.x, m.rate.x);
            m.rate.y = fnma(change, m.n.y, m.rate.y);
            m.rate.z = fnma(fnma(t, c.spin_energy, change), m.n.z, m.rate.z);
            if (with_parameter) m.squared_height_integral = fma(t, z2, m.squared_height_integral);
        };
        const auto drift = [&](double fraction) __attribute__((always_inline)) {
            m.n = advance(m.n, tau * V(S(fraction)), m.rate);
        };
        apply_fractions(coefficients, kick, drift);
    }
    /// Applies kicks and drifts alternately.
    template <class Kick, class Drift>
    KAGERO_INLINE static void apply_fractions(const Coefficients& coefficients, const Kick& kick, const Drift& drift) {
        const double *fraction = coefficients.fractions.data(), *const end = fraction + coefficients.fractions.size();
        if (!coefficients.kick_first) drift(*fraction++);
        for (; fraction + 1 < end; fraction += 2) {
            kick(fraction[0]);
            drift(fraction[1]);
        }
        if (fraction < end) kick(*fraction);
    }

    /// Returns the length in τ after which w is `end`, to third order. ∂(slope)/∂w is approximated by slope/w, which
    /// holds far from the hole.
    template <class V>
    KAGERO_INLINE static V length_to(const SeparatedConstants<V>& c, const RadialMotion<V>& m, const V& end) {
        using S = ScalarOf<V>;
        V difference = end - m.w;
        if constexpr (RadialMotion<V>::compensated) difference = difference - m.w_rounding;
        const V half_slope = V(S(0.5)) * c.slope(m.w);
        const V second_order = difference / fnma(half_slope, difference / m.rate, m.rate);
        const V factor = fma(V(S(1) / S(3)) * m.rate * second_order, half_slope / m.w, half_slope);
        return difference / fnma(second_order, factor, m.rate);
    }
    /// Advances dw/dτ and ψ by a small length with the midpoint rule and sets w to `end`, in the given lanes.
    template <class V>
    KAGERO_INLINE static void correct_radius(const SeparatedConstants<V>& c, const V& length, const V& end,
                                             const MaskOf<V>& lanes, RadialMotion<V>& m) {
        const V middle = V(ScalarOf<V>(0.5)) * (m.w + end);
        m.rate = select(lanes, fnma(length, c.slope(middle), m.rate), m.rate);
        m.azimuth = select(lanes, fma(length, c.azimuth_rate(middle), m.azimuth), m.azimuth);
        m.w = select(lanes, end, m.w);
        if constexpr (RadialMotion<V>::compensated) m.w_rounding = select(lanes, V(ScalarOf<V>(0)), m.w_rounding);
    }
    /// Advances n by a small length with the midpoint rule.
    template <class V>
    KAGERO_INLINE static void correct_direction(const SeparatedConstants<V>& c, const V& length, AngularMotion<V>& m) {
        using S = ScalarOf<V>;
        const V half = V(S(0.5)) * length;
        const Vec3<V> middle = advance(m.n, half, m.rate);
        const V slope = fma(V(S(2)) * c.spin_energy, middle.z * middle.z, c.lambda);
        const Vec3<V> acceleration{-(slope * middle.x), -(slope * middle.y), (c.spin_energy - slope) * middle.z};
        m.n = advance(m.n, length, advance(m.rate, half, acceleration));
        m.rate = advance(m.rate, length, acceleration);
    }
};

}  // namespace kagero

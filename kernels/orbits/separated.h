/// Integration of rays around a spinning black hole by their separated motion in Mino time τ (separated_motion.h).
///
/// The step is an angle in radians that does not depend on the size of the scene: h/c.scale in τ, where c are the
/// constants of the ray. For rays that pass far from the hole it is the angle swept around the centre.
#pragma once

#include "kernels/orbits/separated_start.h"
#include "kernels/orbits/separated_steps.h"

namespace kagero {

/// Stepper for the separated motion.
struct Separated : private SeparatedSteps {
    static constexpr MethodFamily family = MethodFamily::nystroem;
    /// The memory is the separated motion, which would be less accurate if it were recomputed from each state.
    static constexpr bool keeps_memory = true;
    static constexpr bool steps_without_begin = true;  // the memory of every state contains the motion
    static constexpr bool regular_in_both_charts = true;

    template <class System>
    static constexpr const char* refusal() {
        if (System::rescaled)
            return "the method integrates over Mino time, without time rescaling; set integrator.rescale = \"none\"";
        if (refusal_to_carry<System>()) return refusal_to_carry<System>();
        return HasSeparatedMotion<typename System::Hamiltonian>
                   ? nullptr
                   : "the Hamiltonian of this space declares no motion that separates in Mino time";
    }
    /// Returns the numbers of floating-point operations. A gradient is a kick and a drift of w, with the rate of ψ, or
    /// of n; both take about the same number. The conversion to position and momentum takes 190 operations.
    static Operations operations(const Coefficients&, const ProgramOperations& program) {
        return {16, program.event_functions + 190, 40};
    }
    /// The conversions to position and momentum round the state 8 times.
    static constexpr RoundingCounts rounding_counts(const Coefficients& c) {
        return {8 + 0.5 * double(c.fractions.size()), 1, 0.5 * weight_of(c.fractions)};
    }

    template <class System, class V>
    static void begin(const System& system, StepperState<V>& step, const Coefficients&) {
        initialise_separated_motion(system, step.start);
        const RadialMotion<V> radial = radial_motion_of(step.start);
        const AngularMotion<V> angular = angular_motion_of(step.start);
        const SeparatedConstants<V> c(system, step.start.pt(), angular);
        const SeparatedPoint<V> point(c, radial.w, radial.rate, angular.n, angular.rate);
        step.start.velocity = recip(c.scale) * point.velocity;
        step.start.max_step_length = no_bound<V>();
    }

    template <class System, class V>
    static void step(const System& system, StepperState<V>& step, const Coefficients& coefficients) {
        RadialMotion<V> radial = radial_motion_of(step.start);
        AngularMotion<V> angular = angular_motion_of(step.start);
        const SeparatedConstants<V> c(system, step.start.pt(), angular);
        const bool with_parameter = step.options.compute_carried;
        step.h = limit_step(c, radial, step.h, limits_in_space);
        const V tau = step.h * recip(c.scale);
        advance_radius(c, coefficients, tau, radial, with_parameter);
        advance_direction(c, coefficients, tau, angular, with_parameter);
        step.gradients += V(ScalarOf<V>(2)) * gradients_per_step<V>(coefficients);
        set_end(c, step, radial, angular, step.h);
    }

    /// Integrates rays that can meet no surface to the escape sphere: first w, which determines the length in τ, then n
    /// over that length. Rays that are captured, or whose w is no longer positive and finite, stop at the previous
    /// state. A captured ray ends there if `integration.ends_captured` is set and the step to its capture conserves H.
    template <class System, class V>
    static void integrate_to_escape(const System& system, StepperState<V>& step, const Coefficients& coefficients,
                                    EscapeIntegration<V>& integration) {
        using S = ScalarOf<V>;
        const V zero(S(0)), one(S(1));
        RadialMotion<V> radial = radial_motion_of(step.start);
        AngularMotion<V> angular = angular_motion_of(step.start);
        const SeparatedConstants<V> c(system, step.start.pt(), angular);
        const V u_of_sphere(S(1 / integration.radius));
        V tau(zero);
        const MaskOf<V> beyond =
            integrate_radius(system, c, step, coefficients, u_of_sphere, integration, radial, tau);
        integration.arrived =
            return_to_radius(c, step, coefficients, u_of_sphere, integration.h, beyond, radial, tau);
        // The steps of n have equal lengths of at most h radians. Lanes without steps left get the length 0.
        const V angle = tau * c.scale, h = max(integration.h, V(S(std::numeric_limits<float>::min())));
        const V count = max(nearest_integer(min(angle / h, V(S(max_direction_steps))) + V(S(0.5))), one);
        const V length = tau * recip(count);
        for (V done = zero; any(done < count); done = done + one) {
            const V part = select(done < count, length, zero);
            advance_direction(c, coefficients, part, angular, step.options.compute_carried);
        }
        move_onto_sphere(c, step, coefficients, S(integration.radius), integration.arrived, radial, angular);
        step.gradients += (integration.steps + count) * gradients_per_step<V>(coefficients);
        set_end(c, step, radial, angular, tau * c.scale);
    }

    /// Replaces the velocity at the end of the step by its derivative with respect to the step. This function is called
    /// after the event functions have been evaluated at the end.
    template <class V>
    KAGERO_INLINE static void finish(StepperState<V>& step) {
        step.end.velocity = step.stage_vector(0);
        step.end.max_step_length = no_bound<V>();
    }

private:
    /// Limits of one step, which bound the relative change of w (see Orbit).
    struct StepLimits {
        double outward;       ///< greatest relative change of w while the ray moves outward
        double inward;        ///< greatest relative change of w while the ray moves inward
        double past_closest;  ///< greatest angle beyond the closest approach, in radians
        double horizon;       ///< greatest relative change of D close to the horizon
    };
    /// Limits of a step whose ends are converted to position and momentum. Over a longer step, the dense output would
    /// miss too many edges of surfaces.
    static constexpr StepLimits limits_in_space{0.45, 0.8, 0.45, 0.5};
    /// Limits of a step of w alone.
    static constexpr StepLimits limits_in_plane{0.8, 4, 4, 0.5};
    static constexpr int max_corrections = 20;
    static constexpr double max_direction_steps = 1e5;

    /// Returns a step bound that has no effect.
    template <class V>
    static V no_bound() {
        return V(ScalarOf<V>(std::numeric_limits<float>::max()));
    }
    /// Returns the step h, shortened to the limits. Close to the horizon, D may not change by a large factor either,
    /// because dψ/dτ is proportional to 1/D.
    template <class V>
    KAGERO_INLINE static V limit_step(const SeparatedConstants<V>& c, const RadialMotion<V>& m, const V& h,
                                      const StepLimits& limits) {
        using S = ScalarOf<V>;
        const V rate = m.rate * recip(c.scale), inverse = rsqrt(m.w * m.w + rate * rate), sine = m.w * inverse;
        const V inward = min(V(S(limits.inward)) * sine, fma(rate, inverse, V(S(limits.past_closest))));
        V limit = select(rate > V(S(0)), inward, V(S(limits.outward)) * sine);
        const V delta = c.hole.delta(m.w);
        const MaskOf<V> is_close = delta < V(S(0.3));
        if (any(is_close)) {
            // The change of D in τ is at most d τ + ½ e τ², where d and e contain the first and second derivative of w.
            const V slope_of_delta = abs(c.hole.twice_mass - V(S(2)) * c.hole.a2 * m.w);
            const V first = slope_of_delta * abs(m.rate), second = slope_of_delta * abs(c.slope(m.w));
            const V change = V(S(limits.horizon)) * abs(delta);
            const V length = change / (first + sqrt(change * second) + V(std::numeric_limits<float>::min()));
            const MaskOf<V> is_singular = is_close & !c.uses_regular_rate(m.w, m.rate);
            limit = select(is_singular, min(limit, length * c.scale), limit);
        }
        return max(min(h, limit), -limit);
    }

    /// Integrates w until rays have passed the radius 1/end, and adds the length to tau. Returns the lanes that have.
    template <class System, class V>
    KAGERO_INLINE static MaskOf<V> integrate_radius(const System& system, const SeparatedConstants<V>& c,
                                                    StepperState<V>& step, const Coefficients& coefficients,
                                                    const V& end, EscapeIntegration<V>& integration,
                                                    RadialMotion<V>& m, V& tau) {
        using S = ScalarOf<V>;
        const V zero(S(0)), inverse_scale = recip(c.scale);
        MaskOf<V> active = integration.h > zero, passed = no_lanes<V>();
        V steps(zero);
        for (std::uint32_t n = 1; n < integration.max_steps && any(active); ++n) {
            RadialMotion<V> next = m;
            const V length = select(active, limit_step(c, m, integration.h, limits_in_plane), zero) * inverse_scale;
            advance_radius(c, coefficients, length, next, step.options.compute_carried);
            integration.issued_steps += 1;
            integration.active_lane_steps += static_cast<std::uint64_t>(__builtin_popcountll(to_bits(active)));
            active = active & (next.w > zero) & (next.w < V(S(std::numeric_limits<float>::max())));
            const MaskOf<V> beyond = active & (next.w <= end) & (next.rate < zero);
            const MaskOf<V> in_hole = active & !beyond & captured(system, c, next, active);
            active = active & !in_hole;
            if (integration.ends_captured && any(in_hole)) {
                const MaskOf<V> ended = in_hole & (energy_error(c, next) <= V(max_energy_error<S>));
                integration.captured = integration.captured | ended;
                steps = select(ended, steps + V(S(1)), steps);
            }
            if (step.options.compute_energy_error) update_energy_error(c, step, next, active);
            m.copy_lanes(next, active, step.options.compute_carried);
            tau = select(active, tau + length, tau);
            steps = select(active, steps + V(S(1)), steps);
            passed = passed | beyond;
            active = active & !beyond;
        }
        integration.steps = steps;
        return passed;
    }
    /// Moves the rays of `moving` back to the radius 1/end; h is the greatest correction in radians. Returns the lanes
    /// that arrive. See Orbit::integrate_to_escape for the formula of the corrections.
    template <class V>
    KAGERO_INLINE static MaskOf<V> return_to_radius(const SeparatedConstants<V>& c, const StepperState<V>& step,
                                                    const Coefficients& coefficients, const V& end, const V& h,
                                                    MaskOf<V> moving, RadialMotion<V>& m, V& tau) {
        using S = ScalarOf<V>;
        const V rounding(S(0.125) * machine_epsilon<S>), limit = h * recip(c.scale);
        const bool with_parameter = step.options.compute_carried;
        MaskOf<V> arrived = no_lanes<V>();
        for (int i = 0; i < max_corrections && any(moving); ++i) {
            const V length = select(moving, max(min(length_to(c, m, end), limit), -limit), V(S(0)));
            const V angle = length * c.scale;
            const MaskOf<V> last = moving & (abs(angle * angle * angle) <= rounding),
                            full_step = with_parameter ? moving : moving & !last;
            tau = tau + length;
            if (any(full_step)) {
                RadialMotion<V> next = m;
                advance_radius(c, coefficients, length, next, with_parameter);
                m.copy_lanes(next, full_step, with_parameter);
            }
            if (!with_parameter) correct_radius(c, length, end, last, m);
            arrived = arrived | last;
            moving = moving & !last;
        }
        return arrived;
    }
    /// Moves the rays of `moving` from the radius |q| ≈ r onto the sphere |q| = radius, where r depends on n_z.
    template <class V>
    KAGERO_INLINE static void move_onto_sphere(const SeparatedConstants<V>& c, const StepperState<V>& step,
                                               const Coefficients& coefficients, ScalarOf<V> radius, MaskOf<V> moving,
                                               RadialMotion<V>& radial, AngularMotion<V>& angular) {
        using S = ScalarOf<V>;
        const V zero(S(0)), one(S(1)), a_over_radius = c.hole.a * V(S(1) / radius), inverse_radius(S(1) / radius);
        const bool with_parameter = step.options.compute_carried;
        for (int i = 0; i < max_corrections; ++i) {
            const V sine2 = fnma(angular.n.z, angular.n.z, one);
            const V end = inverse_radius * rsqrt(max(fnma(a_over_radius * a_over_radius, sine2, one), V(S(1e-6))));
            moving = moving & (abs(end - radial.w) > V(4 * machine_epsilon<S>) * end);
            if (!any(moving)) return;
            const V length = select(moving, length_to(c, radial, end), zero), angle = length * c.scale;
            const MaskOf<V> is_long = moving & (abs(angle * angle * angle) > V(S(0.125) * machine_epsilon<S>)),
                            full_step = with_parameter ? moving : is_long, midpoint = moving & !full_step;
            if (any(full_step)) {
                const V part = select(full_step, length, zero);
                advance_radius(c, coefficients, part, radial, with_parameter);
                advance_direction(c, coefficients, part, angular, with_parameter);
            }
            if (!any(midpoint)) continue;
            correct_radius(c, length, end, midpoint, radial);
            correct_direction(c, select(midpoint, length, zero), angular);
        }
    }

    /// Returns the lanes of `active` whose ray is captured: it crosses the horizon inward, or it moves inward inside
    /// r = 3M and cannot turn back (Kerr::captured).
    template <class System, class V>
    KAGERO_INLINE static MaskOf<V> captured(const System&, const SeparatedConstants<V>& c, const RadialMotion<V>& m,
                                            const MaskOf<V>& active) {
        using S = ScalarOf<V>;
        const V zero(S(0)), one(S(1)), at_horizon = m.w * c.hole.horizon;
        const MaskOf<V> inside = active & (V(S(1.5)) * c.hole.twice_mass * m.w > one) & (m.rate > zero);
        if (!any(inside | (at_horizon >= one))) return no_lanes<V>();
        const V crosses = fma(c.hole.twice_mass * c.hole.horizon, c.pt, c.hole.a * c.angular_momentum);
        const V w2 = m.w * m.w, b = V(S(1.0 / 3)) * c.three_b * (w2 * m.w), d = V(S(0.5)) * c.twice_c * (w2 * w2);
        const V bound = System::Hamiltonian::radial_polynomial_bound(c.A * w2, b, d, c.pt * c.pt, at_horizon);
        return (inside & (bound > zero)) | ((at_horizon >= one) & (crosses > zero));
    }
    /// Returns the energy error. 2ΣH is (w'² − P)/(w² D); the error is relative to the terms of this difference.
    template <class V>
    KAGERO_INLINE static V energy_error(const SeparatedConstants<V>& c, const RadialMotion<V>& m) {
        const V sum = c.weight(m.w), residual = fms(m.rate, m.rate, fma(c.pt, c.pt, c.radial_term(m.w)));
        return abs(residual) / fma(sum, sum, m.rate * m.rate);
    }
    /// Updates the greatest energy error of the rays in the given lanes.
    template <class V>
    KAGERO_INLINE static void update_energy_error(const SeparatedConstants<V>& c, StepperState<V>& step,
                                                  const RadialMotion<V>& m, const MaskOf<V>& lanes) {
        step.energy_error = select(lanes, max(step.energy_error, energy_error(c, m)), step.energy_error);
    }

    /// Converts the end of a step, after the given angle, to position and momentum. Rays whose angle is 0 keep the
    /// state at the start. `finish` reads the velocity, which is stored as stage vector 0.
    template <class V>
    static void set_end(const SeparatedConstants<V>& c, StepperState<V>& step, const RadialMotion<V>& radial,
                        AngularMotion<V>& angular, const V& angle) {
        using S = ScalarOf<V>;
        const MaskOf<V> unmoved = abs(angle) <= V(S(0));
        const V psi = radial.azimuth + c.hole.azimuth_between(radial.known_from, radial.w);
        const V cosine = cos(psi), sine = sin(psi);
        const auto rotated = [&](const Vec3<V>& v) {
            return Vec3<V>{fnma(sine, v.y, cosine * v.x), fma(sine, v.x, cosine * v.y), v.z};
        };
        // The errors of the method in |n| and n·dn/dτ are removed.
        const Vec3<V> unit = rsqrt(dot(angular.n, angular.n)) * angular.n;
        const Vec3<V> n = rotated(unit), n_rate = rotated(retreat(angular.rate, dot(unit, angular.rate), unit));
        const SeparatedPoint<V> point(c, radial.w, radial.rate, n, n_rate);
        step.end.set(select<V>(unmoved, step.start.q(), point.q), select<V>(unmoved, step.start.p(), point.p));
        step.end.parameter =
            step.start.parameter + fma(c.hole.a2, angular.squared_height_integral, radial.squared_radius_integral);
        const V numbers[separated_memory_size] = {radial.w, radial.rate, n.x, n.y, n.z, n_rate.x, n_rate.y, n_rate.z};
        for (int k = 0; k < separated_memory_size; ++k)
            step.end.stepper_memory[k] = select(unmoved, step.start.stepper_memory[k], numbers[k]);
        step.set_stage_vector(0, select<V>(unmoved, step.start.velocity, recip(c.scale) * point.velocity));
        step.solved = all_lanes<V>();
    }
};

}  // namespace kagero

/// Integration of rays around a spherically symmetric centre in their orbit plane, by Binet's equation: u = 1/r is a
/// function of the swept angle φ. Only the two variables u and w = du/dφ are integrated. The step is an angle in
/// radians and does not depend on the size of the scene.
///
///     du/dφ = w,   dw/dφ = −∂V/∂u,   L dλ/dφ = 1/u² + D(u)
///
/// The Hamiltonian declares V as `orbit_potential`, and D, if it is not zero, as `orbit_delay`. L is |q × p|.
/// E = ½w² + V is constant and separable, so Nyström methods apply (Blanes & Moan 2002). Far from the centre, 1/u²
/// changes much in one step, which makes its integral inaccurate. On a straight line, −w/u is proportional to λ, so
/// most of the integral is expressed by the change of −w/u. For every constant c,
///
///     c/u² = d(−w/u)/dφ + (c − 2E + 2V − u ∂V/∂u)/u²
///
/// The code uses the greater of c = 2E and c = ¼ (u² + w²) at the start of the step. The last term is then small far
/// from the centre. It is a function of u alone, so each kick adds its value to the integral. Position and momentum at
/// the start and the end of a step are computed as well, for event detection. The two sheets of a wormhole are images
/// of each other by inversion; u is the inverse radius on the sheet that the ray is on.
#pragma once

#include "kernels/integrators/composition.h"
#include "kernels/orbits/orbit_start.h"

namespace kagero {

/// Stepper for the motion in the orbit plane.
struct Orbit {
    static constexpr MethodFamily family = MethodFamily::nystroem;
    /// The memory is the motion in the plane, which would be less accurate if it were recomputed from each state.
    static constexpr bool keeps_memory = true;
    static constexpr bool steps_without_begin = true;  // the memory of every state contains the motion

    template <class System>
    static constexpr const char* refusal() {
        if (System::rescaled)
            return "the method integrates over an angle, without time rescaling; set integrator.rescale = \"none\"";
        if (refusal_to_carry<System>()) return refusal_to_carry<System>();
        return HasOrbitPlane<typename System::Hamiltonian>
                   ? nullptr
                   : "the Hamiltonian of this space defines no potential in the orbit plane";
    }
    /// Returns the numbers of floating-point operations. A step with conversions to and from the plane takes 145
    /// operations, including the rotation of the axes. A step within the plane takes 40, for the limit of the step and
    /// the test of whether the ray has reached the sphere. The operations inside sine, cosine and root are included.
    static Operations operations(const Coefficients&, const ProgramOperations& program) {
        return {program.potential_slope + 5, program.event_functions + 145, 40};
    }
    /// The conversions to and from the orbit plane round the state 8 times.
    static constexpr RoundingCounts rounding_counts(const Coefficients& c) {
        return {8 + 0.5 * double(c.fractions.size()), 1, 0.5 * weight_of(c.fractions)};
    }

    template <class System, class V>
    static void begin(const System& system, StepperState<V>& step, const Coefficients&) {
        initialise_orbit(system, step.start);
        const V* const orbit = step.start.stepper_memory;
        step.start.velocity = OrbitFrame<V>(step.start).velocity(orbit[orbit_u], orbit[orbit_w]);
        step.start.max_step_length = no_bound<V>();
    }

    template <class System, class V>
    static void step(const System& system, StepperState<V>& step, const Coefficients& coefficients) {
        OrbitMotion<V> m(system, step);
        step.h = limit_step<V>(m, step.h, limits_in_space<System>);
        advance_angle(system, coefficients, step.h, m);
        step.gradients += gradients_per_step<V>(coefficients);
        set_end(system, step, m, step.h, V(ScalarOf<V>(0)));
    }

    /// Integrates rays that can meet no surface to the escape sphere. All steps stay in the plane, where only u and w
    /// are needed. Rays that are captured, or whose u is no longer positive and finite, stop at the previous state. A
    /// captured ray ends there if `integration.ends_captured` is set and the step to its capture conserves H.
    template <class System, class V>
    static void integrate_to_escape(const System& system, StepperState<V>& step, const Coefficients& coefficients,
                                    EscapeIntegration<V>& integration) {
        using S = ScalarOf<V>;
        const V zero(S(0)), u_of_sphere(S(1 / integration.radius));
        OrbitMotion<V> m(system, step);
        V angle(zero), angle_rounding(zero), steps(zero);
        MaskOf<V> active = integration.h > zero, reached_sphere = no_lanes<V>();
        for (std::uint32_t n = 1; n < integration.max_steps && any(active); ++n) {
            OrbitMotion<V> next = m;
            const V h = select(active, limit_step<V>(m, integration.h, limits_in_plane<System>), zero);
            advance_angle(system, coefficients, h, next);
            integration.issued_steps += 1;
            integration.active_lane_steps += static_cast<std::uint64_t>(__builtin_popcountll(to_bits(active)));
            active = active & (next.u > zero) & (next.u < V(S(std::numeric_limits<float>::max())));
            const MaskOf<V> beyond = active & (next.u <= u_of_sphere) & (next.w < zero);
            if constexpr (System::capturing) {
                const MaskOf<V> in_hole = active & !beyond & !(captured(system, next) > zero);
                active = active & !in_hole;
                if (integration.ends_captured && any(in_hole)) {
                    const MaskOf<V> ended = in_hole & conserves_energy(system, next);
                    integration.captured = integration.captured | ended;
                    steps = select(ended, steps + V(S(1)), steps);
                }
            }
            if (step.options.compute_energy_error) update_energy_error(system, step, next, active);
            m.copy_lanes(next, active);
            m.switch_sheet(system);
            OrbitMotion<V>::add(select(active, h, zero), angle, angle_rounding);
            steps = select(active, steps + V(S(1)), steps);
            reached_sphere = reached_sphere | beyond;
            active = active & !beyond;
        }
        // Rays beyond the sphere are moved back onto the sphere. Each correction computes the angle `back` to third
        // order. The corrections end when the cube of the angle is at the level of rounding. ∂²V/∂u² is approximated by
        // (∂V/∂u)/u, which holds far from the centre. The last correction is a step of the midpoint rule if λ is not
        // requested. With λ, every correction is a step of the method, because λ of a nearly radial ray changes much in
        // a very small angle.
        const V rounding(S(0.125) * machine_epsilon<S>);
        MaskOf<V> moving = reached_sphere;
        integration.arrived = no_lanes<V>();
        for (int i = 0; i < max_corrections && any(moving); ++i) {
            V difference = u_of_sphere - m.u;
            if constexpr (OrbitMotion<V>::compensated) difference = difference - m.u_rounding;
            const V half_slope = V(S(0.5)) * system.orbit().slope(m.u, m.g);
            const V second_order = difference / fnma(half_slope, difference / m.w, m.w);
            const V factor = fma(V(S(1) / S(3)) * m.w * second_order, half_slope / m.u, half_slope);
            const V third_order = difference / fnma(second_order, factor, m.w);
            const V back = select(moving, max(min(third_order, integration.h), -integration.h), zero);
            OrbitMotion<V>::add(back, angle, angle_rounding);
            const MaskOf<V> last = moving & (abs(back * back * back) <= rounding);
            const MaskOf<V> full_step = m.integrates_parameter ? moving : moving & !last;
            if (any(full_step)) {
                OrbitMotion<V> next = m;
                advance_angle(system, coefficients, back, next);
                m.copy_lanes(next, full_step);
            }
            if (!m.integrates_parameter) midpoint_correction(system, m, back, u_of_sphere, last);
            integration.arrived = integration.arrived | last;
            moving = moving & !last;
        }
        integration.steps = steps;
        step.gradients += steps * gradients_per_step<V>(coefficients);
        set_end(system, step, m, angle, angle_rounding);
    }

    /// Replaces the velocity at the end of the step by dq/dφ. This function is called after the event functions have
    /// been evaluated at the end.
    template <class V>
    KAGERO_INLINE static void finish(StepperState<V>& step) {
        step.end.velocity = step.stage_vector(0);
        step.end.max_step_length = no_bound<V>();
    }

private:
    /// Limits of the angle of one step. They bound the relative change of u.
    struct StepLimits {
        double outward;                     ///< greatest relative change of u while the ray moves outward
        double inward;                      ///< greatest relative change of u while the ray moves inward
        double past_closest;                ///< greatest angle beyond the closest approach, in radians
        bool proportional_to_step = false;  ///< the limits are multiplied by the requested step
    };
    /// Returns the limits for a Hamiltonian: `for_black_holes` if it is a spacetime with one sheet. Near a throat V
    /// changes as fast as u, so the limits are smaller. In a medium the index of refraction changes with u, so the
    /// limits are proportional to the requested step.
    template <class H>
    static constexpr StepLimits limits_for(const StepLimits& for_black_holes) {
        if (!H::spacetime) return {0.5, 0.5, 0.5, true};
        return TwoSheeted<H> ? StepLimits{0.4, 0.4, 0.4} : for_black_holes;
    }
    /// Limits of a step whose ends are converted to position and momentum.
    template <class System>
    static constexpr StepLimits limits_in_space = limits_for<typename System::Hamiltonian>({0.6, 1.5, 0.6});
    /// Limits of a step that stays in the plane. These limits only keep the stages of the step away from u = 0.
    template <class System>
    static constexpr StepLimits limits_in_plane = limits_for<typename System::Hamiltonian>({0.8, 4, 4});
    static constexpr int max_corrections = 20;

    /// Returns a step bound that has no effect.
    template <class V>
    static V no_bound() {
        return V(ScalarOf<V>(std::numeric_limits<float>::max()));
    }

    /// Returns the step h, shortened to the limits. In a longer step, the position would not be a smooth function of
    /// the angle. The angle to the closest approach is at least the angle on a straight line, whose sine is w/√(u² +
    /// w²). The sine, which is less than the angle, is used instead of the angle.
    template <class V>
    KAGERO_INLINE static V limit_step(const OrbitMotion<V>& m, const V& h, const StepLimits& limits) {
        using S = ScalarOf<V>;
        const V inverse = rsqrt(m.u * m.u + m.w * m.w);
        const V sine = m.u * inverse;  // on a straight line: sine of the angle between ray and radius
        const V inward = min(V(S(limits.inward)) * sine, fma(m.w, inverse, V(S(limits.past_closest))));
        V limit = select(m.w > V(S(0)), inward, V(S(limits.outward)) * sine);
        if (limits.proportional_to_step) limit = limit * abs(h);
        return max(min(h, limit), -limit);
    }

    /// Advances the ray by the angle h. There are two versions of the code, with and without λ, because the sums for λ
    /// would occupy registers that u and w need.
    template <class System, class V>
    KAGERO_INLINE static void advance_angle(const System& system, const Coefficients& coefficients, const V& h,
                                            OrbitMotion<V>& m) {
        if (m.integrates_parameter) advance_angle_as<true>(system, coefficients, h, m);
        else advance_angle_as<false>(system, coefficients, h, m);
    }
    template <bool with_parameter, class System, class V>
    KAGERO_INLINE static void advance_angle_as(const System& system, const Coefficients& coefficients, const V& h,
                                               OrbitMotion<V>& m) {
        using S = ScalarOf<V>;
        const auto twice_potential = [&] { return V(S(2)) * system.orbit().potential(m.u, m.g); };
        V start_w_over_u(S(0));
        V c(S(0)), c_minus_2e(S(0));  // c and c − 2E in the formula for λ at the top of this file
        V integral(S(0));             // of (c − 2E + 2V − u ∂V/∂u)/u² over the step
        V delay_integral(S(0));       // of D(u) over the step
        if constexpr (with_parameter) {
            const V twice_energy = fma(m.w, m.w, twice_potential());
            c = max(twice_energy, V(S(0.25)) * fma(m.u, m.u, m.w * m.w));
            c_minus_2e = c - twice_energy;
            start_w_over_u = m.w * recip(m.u);
        }
        // u = u_start + u_change, and w = w_start − h · slope_sum, where slope_sum is the weighted sum of ∂V/∂u. The
        // rounding errors of these sums are then relative to the small increments.
        constexpr bool compensated = OrbitMotion<V>::compensated;
        const V first_order = h * m.w, square = h * h, u_start = m.u;
        V slope_sum(S(0)), u_change = m.u_rounding;
        const auto kick = [&](double fraction) __attribute__((always_inline)) {
            const V weight{S(fraction)}, slope = system.orbit().slope(m.u, m.g);
            if constexpr (with_parameter) {
                const V numerator = c_minus_2e + fnma(m.u, slope, twice_potential());
                integral = fma(h * weight, numerator * recip(m.u * m.u), integral);
                if constexpr (HasOrbitDelay<typename System::Hamiltonian>)
                    delay_integral = fma(h * weight, orbit_delay(system, m.u), delay_integral);
            }
            slope_sum = fma(weight, slope, slope_sum);
        };
        const auto drift = [&](double fraction) __attribute__((always_inline)) {
            const V weight{S(fraction)}, increment = fnma(square, slope_sum, first_order);
            if constexpr (compensated) {
                u_change = fma(weight, increment, u_change);
                m.u = u_start + u_change;
            } else {
                m.u = fma(weight, increment, m.u);
            }
        };
        const double *fraction = coefficients.fractions.data(), *const end = fraction + coefficients.fractions.size();
        if (!coefficients.kick_first) drift(*fraction++);
        for (; fraction + 1 < end; fraction += 2) {
            kick(fraction[0]);
            drift(fraction[1]);
        }
        if (fraction < end) kick(*fraction);
        if constexpr (compensated) {
            const V w_change = fnma(h, slope_sum, m.w_rounding), w_start = m.w;
            m.w = w_start + w_change;
            m.u_rounding = u_change - (m.u - u_start);
            m.w_rounding = w_change - (m.w - w_start);
        } else {
            m.w = fnma(h, slope_sum, m.w);
        }
        if constexpr (with_parameter)
            m.parameter +=
                fma(start_w_over_u - m.w * recip(m.u) + integral, recip(c), delay_integral) * recip(m.angular_momentum);
    }
    /// Advances w by a small angle with the midpoint rule and sets u to `end`, in the given lanes. λ is not updated.
    template <class System, class V>
    KAGERO_INLINE static void midpoint_correction(const System& system, OrbitMotion<V>& m, const V& angle,
                                                  const V& end, const MaskOf<V>& lanes) {
        const V middle = V(ScalarOf<V>(0.5)) * (m.u + end);
        m.w = select(lanes, fnma(angle, system.orbit().slope(middle, m.g), m.w), m.w);
        m.u = select(lanes, end, m.u);
        if constexpr (OrbitMotion<V>::compensated) m.u_rounding = select(lanes, V(ScalarOf<V>(0)), m.u_rounding);
    }
    /// Returns the number of evaluations of ∂V/∂u in `advance_angle`.
    template <class V>
    static V gradients_per_step(const Coefficients& coefficients) {
        return V(ScalarOf<V>((coefficients.fractions.size() + coefficients.kick_first) / 2));
    }

    /// Returns position and momentum of the ray with respect to the axes of the orbit plane: x is radial, y is
    /// tangential.
    template <class System, class V>
    KAGERO_INLINE static State<V> state_in_plane(const System& system, const OrbitMotion<V>& m) {
        using H = typename System::Hamiltonian;
        const V zero(ScalarOf<V>(0)), l = m.angular_momentum;
        const V radial = radial_momentum<H>(system, m.u, -(l * m.w), l, m.pt);
        return {{recip(m.u), zero, zero, radial, l * m.u, zero, m.pt}};
    }
    /// Returns the event function `captured`, which is ≤ 0 where the ray is captured.
    template <class System, class V>
    KAGERO_INLINE static V captured(const System& system, const OrbitMotion<V>& m) {
        const State<V> here = state_in_plane(system, m);
        const V &r = here.y[component_x], &zero = here.y[component_y];
        const Vec3<V> velocity{-(m.w * r * r), r, zero};
        return System::Hamiltonian::captured(system.template parameters<V>(), here.q(), here.p(), velocity, m.pt);
    }
    /// Returns the lanes in which H is still close to its level.
    template <class System, class V>
    KAGERO_INLINE static MaskOf<V> conserves_energy(const System& system, const OrbitMotion<V>& m) {
        using S = ScalarOf<V>;
        const EventFunctions<V> here = system.event_functions(state_in_plane(system, m));
        return here.energy_residual * here.energy_residual <=
               V(max_energy_error<S> * max_energy_error<S>) * here.squared_energy_terms;
    }
    /// Updates the greatest energy error of the rays in the given lanes.
    template <class System, class V>
    KAGERO_INLINE static void update_energy_error(const System& system, StepperState<V>& step, const OrbitMotion<V>& m,
                                                  const MaskOf<V>& lanes) {
        const EventFunctions<V> here = system.event_functions(state_in_plane(system, m.on_first_sheet(system)));
        const V error = abs(here.energy_residual) / here.energy_scale;
        step.energy_error = select(lanes, max(step.energy_error, error), step.energy_error);
    }

    /// Converts the end of a step, after the given angle, to position and momentum. Rays whose angle is 0 keep the
    /// state at the start. `finish` reads the velocity, which is stored as stage vector 0.
    template <class System, class V>
    static void set_end(const System& system, StepperState<V>& step, const OrbitMotion<V>& motion, const V& angle,
                        const V& angle_rounding) {
        const MaskOf<V> unmoved = abs(angle) <= V(ScalarOf<V>(0));
        const OrbitMotion<V> m = motion.on_first_sheet(system);
        const State<V> here = state_in_plane(system, m);
        OrbitFrame<V> frame(step.start);
        frame.rotate(angle, angle_rounding);
        const Vec3<V> q = here.y[component_x] * frame.radial;
        const Vec3<V> p = advance(here.y[component_px] * frame.radial, here.y[component_py], frame.tangential);
        step.end.set(select<V>(unmoved, step.start.q(), q), select<V>(unmoved, step.start.p(), p));
        step.end.parameter = m.parameter;
        m.store_to(step.end);
        frame.store_to(step.end);
        const Vec3<V> velocity = select<V>(unmoved, step.start.velocity, frame.velocity(m.u, m.w));
        step.set_stage_vector(0, velocity);
        step.solved = all_lanes<V>();
    }

    /// Returns the radial momentum p·q/r. It is v = −L w if p is parallel to the ray. Hamiltonians for which p is not
    /// parallel to the ray declare `radial_momentum`.
    template <class H, class System, class V>
    KAGERO_INLINE static V radial_momentum(const System& system, const V& u, const V& v, const V& l, const V& pt) {
        if constexpr (requires { H::radial_momentum(system.template parameters<V>(), u, v, l, pt); })
            return H::radial_momentum(system.template parameters<V>(), u, v, l, pt);
        else
            return v;
    }
};

}  // namespace kagero

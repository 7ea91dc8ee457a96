/// Integration of rays around a centre in their orbit plane, by Binet's equation: u = 1/r as a function of the swept
/// angle φ. Two of the six variables remain. The step is an angle in radians and does not depend on the size of the
/// scene.
///
///     du/dφ = w,   dw/dφ = −∂V/∂u,   L dλ/dφ = 1/u² + D(u)
///
/// The header of the Hamiltonian defines V, and D where it is not zero. L is |q × p|. E = ½w² + V is constant and
/// separable, so Nyström fractions apply (Blanes & Moan 2002). Far from the centre, 1/u² changes much in one step. The
/// term −w/u, which is proportional to λ on a straight line, removes most of this change. For every constant c,
///
///     c/u² = d(−w/u)/dφ + (c − 2E + 2V − u ∂V/∂u)/u²
///
/// The code uses c = 2E, or ¼ (u² + w²) at the start of the step if that is greater. The last term is then small far
/// from the centre. It is a function of u alone, so each kick adds it. The start and the end of a step are also
/// computed as position and momentum, for event detection. The two sheets of a wormhole are images of each other by
/// inversion; u is the inverse radius on the sheet that the ray is on.
#pragma once

#include "kernels/integrators/composition.h"
#include "kernels/orbits/orbit_start.h"

namespace kagero {

/// Stepper for the motion in the orbit plane.
struct Orbit {
    static constexpr MethodFamily family = MethodFamily::nystroem;
    static constexpr bool keeps_memory = true;  ///< the orbit; it would be less accurate if recomputed from each state
    static constexpr bool resumes = true;

    template <class System>
    static constexpr const char* refusal() {
        if (System::rescaled)
            return "it steps in the angle of the orbit, without time rescaling; set integrator.rescale = \"none\"";
        if (refusal_to_carry<System>()) return refusal_to_carry<System>();
        return HasOrbitPlane<typename System::Hamiltonian>
                   ? nullptr
                   : "the Hamiltonian of this space defines no potential in the orbit plane";
    }
    /// Returns the numbers of operations. A step with conversions to and from the plane takes 145 operations, including
    /// the rotation of the axes. A step within the plane takes 40, for the limit of the step and the test of whether it
    /// is the last. Sines, cosines and roots count as the operations that they consist of.
    static Operations operations(const Coefficients&, const ProgramOperations& program) {
        return {program.slope + 5, program.event_functions + 145, 40};
    }
    /// The conversions to and from the orbit plane round the state 8 times.
    static constexpr RoundingCounts roundings(const Coefficients& c) {
        return {8 + 0.5 * double(c.fractions.size()), 1, 0.5 * weight_of(c.fractions)};
    }

    template <class System, class V>
    static void begin(const System& system, StepperState<V>& f, const Coefficients&) {
        enter_orbit(system, f.start);
        const V* const orbit = f.start.stepper_memory;
        f.start.velocity = OrbitFrame<V>(f.start).velocity(orbit[orbit_u], orbit[orbit_w]);
        f.start.max_step_length = no_bound<V>();
    }

    template <class System, class V>
    static void step(const System& system, StepperState<V>& f, const Coefficients& coefficients) {
        OrbitMotion<V> m(system, f);
        f.h = limited<V>(m, f.h, limits_in_space<System>);
        advance_angle(system, coefficients, f.h, m);
        f.gradients += kicks<V>(coefficients);
        set_end(system, f, m, f.h, V(ScalarOf<V>(0)));
    }

    /// Integrates rays that can meet no surface to the escape sphere. It stays in the plane, where only u and w are
    /// needed. Rays that are captured, or whose u leaves the valid range, stop at the last valid state.
    template <class System, class V>
    static void integrate_to_escape(const System& system, StepperState<V>& f, const Coefficients& coefficients,
                                    EscapeIntegration<V>& integration) {
        using S = ScalarOf<V>;
        const V zero(S(0)), u_of_sphere(S(1 / integration.radius));
        OrbitMotion<V> m(system, f);
        V angle(zero), angle_rest(zero), steps(zero);
        MaskOf<V> active = integration.h > zero, arriving = no_lanes<V>();
        for (std::uint32_t n = 1; n < integration.max_steps && any(active); ++n) {
            OrbitMotion<V> next = m;
            const V h = select(active, limited<V>(m, integration.h, limits_in_plane<System>), zero);
            advance_angle(system, coefficients, h, next);
            integration.issued_steps += 1;
            integration.active_lane_steps += static_cast<std::uint64_t>(__builtin_popcountll(to_bits(active)));
            active = active & (next.u > zero) & (next.u < V(S(std::numeric_limits<float>::max())));
            const MaskOf<V> beyond = active & (next.u <= u_of_sphere) & (next.w < zero);
            if constexpr (System::capturing) active = beyond | (active & (captured(system, next) > zero));
            if (f.options.compute_energy_error) update_energy_error(system, f, next, active);
            m.copy_lanes(next, active);
            m.change_sheet(system);
            OrbitMotion<V>::add(select(active, h, zero), angle, angle_rest);
            steps = select(active, steps + V(S(1)), steps);
            arriving = arriving | beyond;
            active = active & !beyond;
        }
        // Rays beyond the sphere are moved back onto it. Each correction computes the angle to third order. The
        // corrections end when the cube of the angle is at the level of rounding. ∂²V/∂u² is approximated by (∂V/∂u)/u,
        // which holds far from the centre. The last correction is a step of the midpoint rule, unless λ is requested.
        // With λ it is a full step, because a nearly radial ray covers much λ in a very small angle.
        const V rounding(S(0.125) * machine_epsilon<S>);
        MaskOf<V> moving = arriving;
        integration.arrived = no_lanes<V>();
        for (int i = 0; i < max_corrections && any(moving); ++i) {
            V difference = u_of_sphere - m.u;
            if constexpr (OrbitMotion<V>::compensated) difference = difference - m.u_rest;
            const V slope = system.orbit().slope(m.u, m.g), half = V(S(0.5)) * slope;
            const V second = difference / fnma(half, difference / m.w, m.w);
            const V third = difference / fnma(second, fma(V(S(1) / S(3)) * m.w * second, half / m.u, half), m.w);
            const V back = select(moving, max(min(third, integration.h), -integration.h), zero);
            OrbitMotion<V>::add(back, angle, angle_rest);
            const MaskOf<V> last = moving & (abs(back * back * back) <= rounding);
            const MaskOf<V> full_step = m.want_parameter ? moving : moving & !last;
            if (any(full_step)) {
                OrbitMotion<V> next = m;
                advance_angle(system, coefficients, back, next);
                m.copy_lanes(next, full_step);
            }
            if (!m.want_parameter) midpoint_correction(system, m, back, u_of_sphere, last);
            integration.arrived = integration.arrived | last;
            moving = moving & !last;
        }
        integration.steps = steps;
        f.gradients += steps * kicks<V>(coefficients);
        set_end(system, f, m, angle, angle_rest);
    }

    /// Replaces the velocity at the end of the step with dq/dφ. It is called after the event functions have been
    /// evaluated at the end.
    template <class V>
    KAGERO_INLINE static void finish(StepperState<V>& f) {
        f.end.velocity = force_in(f.stage[0]);
        f.end.max_step_length = no_bound<V>();
    }

private:
    /// Limits of the angle of one step. They bound the relative change of u.
    struct StepLimits {
        double outward;         ///< greatest relative change of u while the ray moves outward
        double inward;          ///< greatest relative change of u while the ray moves inward
        double past_closest;    ///< greatest angle beyond the closest approach, in radians
        bool per_step = false;  ///< the limits are multiplied by the requested step
    };
    /// Returns the limits for a Hamiltonian. Near a throat V changes as fast as u, so the limits are smaller. In a
    /// medium the index of refraction changes with u, so the limits are proportional to the requested step.
    template <class H>
    static constexpr StepLimits limits_for(const StepLimits& around_a_hole) {
        if (!H::spacetime) return {0.5, 0.5, 0.5, true};
        return TwoSheeted<H> ? StepLimits{0.4, 0.4, 0.4} : around_a_hole;
    }
    /// Limits of a step whose ends are converted to position and momentum.
    template <class System>
    static constexpr StepLimits limits_in_space = limits_for<typename System::Hamiltonian>({0.6, 1.5, 0.6});
    /// Limits of a step that stays in the plane. They only keep the stages of the step away from u = 0.
    template <class System>
    static constexpr StepLimits limits_in_plane = limits_for<typename System::Hamiltonian>({0.8, 4, 4});
    static constexpr int max_corrections = 20;

    template <class V>
    static V no_bound() {
        return V(ScalarOf<V>(std::numeric_limits<float>::max()));
    }

    /// Returns the step h, shortened to the limits. In a longer step, the curve in space would not be a smooth function
    /// of the angle. The angle to the closest approach is at least that of a straight line, and the sine of that angle
    /// is a lower bound for it.
    template <class V>
    KAGERO_INLINE static V limited(const OrbitMotion<V>& m, const V& h, const StepLimits& limits) {
        using S = ScalarOf<V>;
        const V inverse = rsqrt(m.u * m.u + m.w * m.w);
        const V sine = m.u * inverse;  // on a straight line, of the angle between ray and radius
        const V inward = min(V(S(limits.inward)) * sine, fma(m.w, inverse, V(S(limits.past_closest))));
        V limit = select(m.w > V(S(0)), inward, V(S(limits.outward)) * sine);
        if (limits.per_step) limit = limit * abs(h);
        return max(min(h, limit), -limit);
    }

    /// Advances the ray by the angle h. There are two versions of the code, with and without λ, because the sums for λ
    /// would occupy registers that u and w need.
    template <class System, class V>
    KAGERO_INLINE static void advance_angle(const System& system, const Coefficients& coefficients, const V& h,
                                            OrbitMotion<V>& m) {
        if (m.want_parameter) advance_angle_as<true>(system, coefficients, h, m);
        else advance_angle_as<false>(system, coefficients, h, m);
    }
    template <bool with_parameter, class System, class V>
    KAGERO_INLINE static void advance_angle_as(const System& system, const Coefficients& coefficients, const V& h,
                                               OrbitMotion<V>& m) {
        using S = ScalarOf<V>;
        const auto twice_potential = [&] { return V(S(2)) * system.orbit().potential(m.u, m.g); };
        V start_w_over_u(S(0));
        V c(S(0)), c_minus_2e(S(0));  // of the formula for λ above
        V integral(S(0)), delay_integral(S(0));  // of (c − 2E + 2V − u ∂V/∂u)/u², and of D(u)
        if constexpr (with_parameter) {
            const V twice_energy = fma(m.w, m.w, twice_potential());
            c = max(twice_energy, V(S(0.25)) * fma(m.u, m.u, m.w * m.w));
            c_minus_2e = c - twice_energy;
            start_w_over_u = m.w * recip(m.u);
        }
        // u is its value at the start plus `gain`, and w is its value at the start minus h · `pull`. The rounding
        // errors of these sums are then relative to the small increments.
        constexpr bool compensated = OrbitMotion<V>::compensated;
        const V first_order = h * m.w, square = h * h, from = m.u;
        V pull(S(0)), gain = m.u_rest;
        const auto kick = [&](double fraction) __attribute__((always_inline)) {
            const V weight{S(fraction)}, slope = system.orbit().slope(m.u, m.g);
            if constexpr (with_parameter) {
                const V numerator = c_minus_2e + fnma(m.u, slope, twice_potential());
                integral = fma(h * weight, numerator * recip(m.u * m.u), integral);
                if constexpr (HasOrbitDelay<typename System::Hamiltonian>)
                    delay_integral = fma(h * weight, orbit_delay(system, m.u), delay_integral);
            }
            pull = fma(weight, slope, pull);
        };
        const auto drift = [&](double fraction) __attribute__((always_inline)) {
            const V weight{S(fraction)}, increment = fnma(square, pull, first_order);
            if constexpr (compensated) {
                gain = fma(weight, increment, gain);
                m.u = from + gain;
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
            const V change = fnma(h, pull, m.w_rest), before = m.w;
            m.w = before + change;
            m.u_rest = gain - (m.u - from);
            m.w_rest = change - (m.w - before);
        } else {
            m.w = fnma(h, pull, m.w);
        }
        if constexpr (with_parameter)
            m.parameter +=
                fma(start_w_over_u - m.w * recip(m.u) + integral, recip(c), delay_integral) * recip(m.momentum);
    }
    /// Advances w by a small angle with the midpoint rule and sets u = `end`, in the selected lanes. It does not update
    /// λ.
    template <class System, class V>
    KAGERO_INLINE static void midpoint_correction(const System& system, OrbitMotion<V>& m, const V& angle,
                                                  const V& end, const MaskOf<V>& lanes) {
        const V middle = V(ScalarOf<V>(0.5)) * (m.u + end);
        m.w = select(lanes, fnma(angle, system.orbit().slope(middle, m.g), m.w), m.w);
        m.u = select(lanes, end, m.u);
        if constexpr (OrbitMotion<V>::compensated) m.u_rest = select(lanes, V(ScalarOf<V>(0)), m.u_rest);
    }
    /// Returns the number of derivative evaluations of `advance_angle`.
    template <class V>
    static V kicks(const Coefficients& coefficients) {
        return V(ScalarOf<V>((coefficients.fractions.size() + coefficients.kick_first) / 2));
    }

    /// Returns position and momentum of the ray in the axes of the orbit plane: x is radial, y is tangential.
    template <class System, class V>
    KAGERO_INLINE static State<V> in_plane(const System& system, const OrbitMotion<V>& m) {
        const V zero(ScalarOf<V>(0)),
            radial = radial_momentum<typename System::Hamiltonian>(system, m.u, -(m.momentum * m.w), m.momentum, m.pt);
        return {{recip(m.u), zero, zero, radial, m.momentum * m.u, zero, m.pt}};
    }
    /// Returns the capture function; it is ≤ 0 where the ray is captured.
    template <class System, class V>
    KAGERO_INLINE static V captured(const System& system, const OrbitMotion<V>& m) {
        const State<V> here = in_plane(system, m);
        const V &r = here.y[component_x], &zero = here.y[component_y];
        const Vec3<V> velocity{-(m.w * r * r), r, zero};
        return System::Hamiltonian::captured(system.template parameters<V>(), here.q(), here.p(), velocity, m.pt);
    }
    /// Updates the greatest energy error of the rays in the selected lanes.
    template <class System, class V>
    KAGERO_INLINE static void update_energy_error(const System& system, StepperState<V>& f, const OrbitMotion<V>& m,
                                                  const MaskOf<V>& lanes) {
        const EventFunctions<V> here = system.event_functions(in_plane(system, m.on_first_sheet(system)));
        f.energy_error = select(lanes, max(f.energy_error, abs(here.energy_residual) / here.size), f.energy_error);
    }

    /// Converts the end of a step to position and momentum. Rays whose angle is 0 keep the state at the start. `finish`
    /// reads the velocity from f.stage.
    template <class System, class V>
    static void set_end(const System& system, StepperState<V>& f, const OrbitMotion<V>& motion, const V& angle,
                        const V& rest) {
        const MaskOf<V> still = abs(angle) <= V(ScalarOf<V>(0));
        const OrbitMotion<V> m = motion.on_first_sheet(system);
        const State<V> here = in_plane(system, m);
        OrbitFrame<V> frame(f.start);
        frame.rotate(angle, rest);
        const Vec3<V> q = here.y[component_x] * frame.radial;
        const Vec3<V> p = advance(here.y[component_px] * frame.radial, here.y[component_py], frame.tangential);
        f.end.set(select<V>(still, f.start.q(), q), select<V>(still, f.start.p(), p));
        f.end.parameter = m.parameter;
        m.store_to(f.end);
        frame.store_to(f.end);
        const Vec3<V> velocity = select<V>(still, f.start.velocity, frame.velocity(m.u, m.w));
        f.stage[0][0] = velocity.x;
        f.stage[0][1] = velocity.y;
        f.stage[0][2] = velocity.z;
        f.solved = all_lanes<V>();
    }

    /// Returns the radial momentum p·q/r. If p is parallel to the ray it is `along` = −L w. Hamiltonians for which this
    /// does not hold define `radial_momentum`.
    template <class H, class System, class V>
    KAGERO_INLINE static V radial_momentum(const System& system, const V& u, const V& along, const V& l, const V& pt) {
        if constexpr (requires { H::radial_momentum(system.template parameters<V>(), u, along, l, pt); })
            return H::radial_momentum(system.template parameters<V>(), u, along, l, pt);
        else
            return along;
    }
};

}  // namespace kagero

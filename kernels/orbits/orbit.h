/// Rays about a centre, in the plane of their orbit: u = 1/r as a function of the angle swept (Binet's equation). Of
/// six variables two are left, and the step is an angle, in radians, whatever the size of things.
///
///     du/dφ = w,   dw/dφ = −∂V/∂u,   L dλ/dφ = 1/u² + D(u)
///
/// with V, and D where it is not zero, from the Hamiltonian's header, and L = |q × p|. E = ½w² + V is constant and
/// separable: Nyström's fractions serve it (Blanes & Moan 2002). Far out 1/u² changes much in a step, but −w/u, which
/// is λ on a straight line, takes that away: whatever the constant c,
///
///     c/u² = d(−w/u)/dφ + (c − 2E + 2V − u ∂V/∂u)/u²
///
/// and with c = 2E, or ¼ (u² + w²) at the start of the step where that is more, the rest is small far out. It is a
/// function of u alone, and what a kick adds. Start and end of a step are points of space again, for whatever is met
/// there. Of two universes joined by a throat, each the other's image by inversion, u is the inverse radius in that
/// where the ray is.
#pragma once

#include "kernels/integrators/composition.h"
#include "kernels/orbits/orbit_start.h"

namespace kagero {

struct Orbit {
    static constexpr Family family = Family::nystroem;
    static constexpr bool carries = true;  ///< the orbit, which no place along the ray tells as well as its start
    static constexpr bool resumes = true;

    template <class System>
    static constexpr const char* refusal() {
        if (System::rescaled) return "it steps in the angle of the orbit, not in a rescaled parameter";
        if (refusal_to_carry<System>()) return refusal_to_carry<System>();
        return Orbiting<typename System::Hamiltonian> ? nullptr
                                                      : "its Hamiltonian states no potential of the orbit plane";
    }
    /// Into the plane, turning its axes, and out of it, or how long the step may be and whether it is the last: counted
    /// below, with sine, cosine and roots as what they are made of.
    static Operations operations(const Coefficients&, const ProgramOperations& program) {
        return {program.slope + 5, program.event_functions + 145, 40};
    }
    /// Into the plane of the orbit and out of it.
    static constexpr RoundingCounts roundings(const Coefficients& c) {
        return {8 + 0.5 * double(c.fractions.size()), 1, 0.5 * weight_of(c.fractions)};
    }

    template <class System, class V>
    static void begin(const System& system, StepperState<V>& f, const Coefficients&) {
        enter_orbit(system, f.start);
        f.start.velocity = OrbitFrame<V>(f.start).velocity(f.start.carry[orbit_u], f.start.carry[orbit_w]);
        f.start.max_step_length = no_bound<V>();
    }

    template <class System, class V>
    static void step(const System& system, StepperState<V>& f, const Coefficients& coefficients) {
        OrbitMotion<V> m(system, f);
        f.h = longest<V>(m, f.h, in_steps<System>);
        turn(system, coefficients, f.h, m);
        f.gradients += kicks<V>(coefficients);
        leave(system, f, m, f.h, V(ScalarOf<V>(0)));
    }

    /// The way of rays that meet nothing, to the escape sphere: all of it in the plane, where nothing but u and w is
    /// needed. Those that are captured, or get lost, stop at the last place before.
    template <class System, class V>
    static void integrate_to_escape(const System& system, StepperState<V>& f, const Coefficients& coefficients,
                                    EscapeIntegration<V>& way) {
        using S = ScalarOf<V>;
        const V zero(S(0)), rim(S(1 / way.radius));
        OrbitMotion<V> m(system, f);
        V angle(zero), angle_rest(zero), steps(zero);
        MaskOf<V> open = way.h > zero, arriving = never<V>();
        for (std::uint32_t n = 1; n < way.max_steps && any(open); ++n) {
            OrbitMotion<V> next = m;
            const V h = select(open, longest<V>(m, way.h, alone<System>), zero);
            turn(system, coefficients, h, next);
            way.issued_steps += 1,
                way.active_lane_steps += static_cast<std::uint64_t>(__builtin_popcountll(to_bits(open)));
            open = open & (next.u > zero) & (next.u < V(S(std::numeric_limits<float>::max())));
            const MaskOf<V> beyond = open & (next.u <= rim) & (next.w < zero);
            if constexpr (System::capturing) open = beyond | (open & (captured(system, next) > zero));
            if (f.options.want_energy) worst_energy(system, f, next, open);
            m.take(next, open);
            m.change_sides(system);
            OrbitMotion<V>::add(select(open, h, zero), angle, angle_rest);
            steps = select(open, steps + V(S(1)), steps);
            arriving = arriving | beyond, open = open & !beyond;
        }
        // From beyond the sphere back onto it: the angle to third order, until what second order leaves out is a
        // rounding. ∂²V/∂u² is taken as (∂V/∂u)/u, as it is far out. The last correction is a step of the midpoint
        // rule. Where λ is wanted it is not: a ray that hardly turns covers much λ in the smallest angle.
        const V rounding(S(0.125) * machine_epsilon<S>);
        MaskOf<V> moving = arriving;
        way.arrived = never<V>();
        for (int i = 0; i < max_corrections && any(moving); ++i) {
            V fall = rim - m.u;
            if constexpr (OrbitMotion<V>::compensated) fall = fall - m.u_rest;
            const V slope = system.orbit().slope(m.u, m.g), half = V(S(0.5)) * slope;
            const V second = fall / fnma(half, fall / m.w, m.w);
            const V third = fall / fnma(second, fma(V(S(1) / S(3)) * m.w * second, half / m.u, half), m.w);
            const V back = select(moving, max(min(third, way.h), -way.h), zero);
            OrbitMotion<V>::add(back, angle, angle_rest);
            const MaskOf<V> there = moving & (abs(back * back * back) <= rounding);
            const MaskOf<V> turning = m.want_parameter ? moving : moving & !there;
            if (any(turning)) {
                OrbitMotion<V> next = m;
                turn(system, coefficients, back, next);
                m.take(next, turning);
            }
            if (!m.want_parameter) finish(system, m, back, rim, there);
            way.arrived = way.arrived | there, moving = moving & !there;
        }
        way.steps = steps;
        f.gradients += steps * kicks<V>(coefficients);
        leave(system, f, m, angle, angle_rest);
    }

    /// After the end has been event_function_count: its velocity is that along the orbit, by the angle.
    template <class V>
    KAGERO_INLINE static void finish(StepperState<V>& f) {
        f.end.velocity = force_in(f.stage[0]);
        f.end.max_step_length = no_bound<V>();
    }

private:
    /// Greatest share by which u may change in a step; and in one that no point of space is asked of, so that its
    /// stages keep off u = 0. Inward it may be much: what comes closest within the step goes out again by `outside` at
    /// most, in radians from there. Through a throat V changes as u does. So it does where an index changes: there it
    /// is a share of the step asked for.
    struct Change {
        double outward, inward, outside;
        bool of_step = false;
    };
    template <class H>
    static constexpr Change most(const Change& around_a_hole) {
        return !H::spacetime ? Change{0.5, 0.5, 0.5, true} : TwoSheeted<H> ? Change{0.4, 0.4, 0.4} : around_a_hole;
    }
    template <class System>
    static constexpr Change in_steps = most<typename System::Hamiltonian>({0.6, 1.5, 0.6});
    template <class System>
    static constexpr Change alone = most<typename System::Hamiltonian>({0.8, 4, 4});
    static constexpr int max_corrections = 20;

    template <class V>
    static V no_bound() {
        return V(ScalarOf<V>(std::numeric_limits<float>::max()));
    }

    /// A step is cut where r would change by too much: beyond it the curve in space would no longer be a smooth
    /// function of the angle. The angle to where a ray comes closest is that of a straight line at least, of which the
    /// sine is a lower bound.
    template <class V>
    KAGERO_INLINE static V longest(const OrbitMotion<V>& m, const V& h, const Change& change) {
        using S = ScalarOf<V>;
        const V inverse = rsqrt(m.u * m.u + m.w * m.w), share = m.u * inverse;
        const V inward = min(V(S(change.inward)) * share, fma(m.w, inverse, V(S(change.outside))));
        V most = select(m.w > V(S(0)), inward, V(S(change.outward)) * share);
        if (change.of_step) most = most * abs(h);
        return max(min(h, most), -most);
    }

    /// Along the ray by an angle. Whether λ is wanted is asked once: its sums would take registers from u and w.
    template <class System, class V>
    KAGERO_INLINE static void turn(const System& system, const Coefficients& coefficients, const V& h,
                                   OrbitMotion<V>& m) {
        if (m.want_parameter) turn_as<true>(system, coefficients, h, m);
        else turn_as<false>(system, coefficients, h, m);
    }
    template <bool with_parameter, class System, class V>
    KAGERO_INLINE static void turn_as(const System& system, const Coefficients& coefficients, const V& h,
                                      OrbitMotion<V>& m) {
        using S = ScalarOf<V>;
        const auto twice_potential = [&] { return V(S(2)) * system.orbit().potential(m.u, m.g); };
        V start(S(0)), scale(S(0)), surplus(S(0)), gained(S(0)), delayed(S(0));
        if constexpr (with_parameter) {
            const V twice_energy = fma(m.w, m.w, twice_potential());
            scale = max(twice_energy, V(S(0.25)) * fma(m.u, m.u, m.w * m.w));
            surplus = scale - twice_energy, start = m.w * recip(m.u);
        }
        // u = start + gain, and w as at the start less h times the pull: so the roundings of a sum are those of what is
        // added.
        constexpr bool compensated = OrbitMotion<V>::compensated;
        const V way = h * m.w, square = h * h, from = m.u;
        V pull(S(0)), gain = m.u_rest;
        const auto kick = [&](double fraction) __attribute__((always_inline)) {
            const V share{S(fraction)}, slope = system.orbit().slope(m.u, m.g);
            if constexpr (with_parameter) {
                const V rest = surplus + fnma(m.u, slope, twice_potential());
                gained = fma(h * share, rest * recip(m.u * m.u), gained);
                if constexpr (Delaying<typename System::Hamiltonian>)
                    delayed = fma(h * share, orbit_delay(system, m.u), delayed);
            }
            pull = fma(share, slope, pull);
        };
        const auto drift = [&](double fraction) __attribute__((always_inline)) {
            const V share{S(fraction)}, towards = fnma(square, pull, way);
            if constexpr (compensated) gain = fma(share, towards, gain), m.u = from + gain;
            else m.u = fma(share, towards, m.u);
        };
        const double *fraction = coefficients.fractions.data(), *const end = fraction + coefficients.fractions.size();
        if (!coefficients.kick_first) drift(*fraction++);
        for (; fraction + 1 < end; fraction += 2) kick(fraction[0]), drift(fraction[1]);
        if (fraction < end) kick(*fraction);
        if constexpr (compensated) {
            const V change = fnma(h, pull, m.w_rest), before = m.w;
            m.w = before + change;
            m.u_rest = gain - (m.u - from), m.w_rest = change - (m.w - before);
        } else {
            m.w = fnma(h, pull, m.w);
        }
        if constexpr (with_parameter)
            m.parameter += fma(start - m.w * recip(m.u) + gained, recip(scale), delayed) * recip(m.momentum);
    }
    /// By a small angle to where 1/r is `end`, in these lanes; not λ.
    template <class System, class V>
    KAGERO_INLINE static void finish(const System& system, OrbitMotion<V>& m, const V& angle, const V& end,
                                     const MaskOf<V>& lanes) {
        const V middle = V(ScalarOf<V>(0.5)) * (m.u + end);
        m.w = select(lanes, fnma(angle, system.orbit().slope(middle, m.g), m.w), m.w);
        m.u = select(lanes, end, m.u);
        if constexpr (OrbitMotion<V>::compensated) m.u_rest = select(lanes, V(ScalarOf<V>(0)), m.u_rest);
    }
    /// How often `turn` differentiates.
    template <class V>
    static V kicks(const Coefficients& coefficients) {
        return V(ScalarOf<V>((coefficients.fractions.size() + coefficients.kick_first) / 2));
    }

    /// The ray as a state of H, in axes of its own: x outward, y across.
    template <class System, class V>
    KAGERO_INLINE static State<V> in_plane(const System& system, const OrbitMotion<V>& m) {
        const V zero(ScalarOf<V>(0)),
            radial = radial_momentum<typename System::Hamiltonian>(system, m.u, -(m.momentum * m.w), m.momentum, m.pt);
        return {{recip(m.u), zero, zero, radial, m.momentum * m.u, zero, m.pt}};
    }
    /// ≤ 0 where it is captured.
    template <class System, class V>
    KAGERO_INLINE static V captured(const System& system, const OrbitMotion<V>& m) {
        const State<V> here = in_plane(system, m);
        const V &r = here.y[component_x], &zero = here.y[component_y];
        const Vec3<V> velocity{-(m.w * r * r), r, zero};
        return System::Hamiltonian::captured(system.template parameters<V>(), here.q(), here.p(), velocity, m.pt);
    }
    template <class System, class V>
    KAGERO_INLINE static void worst_energy(const System& system, StepperState<V>& f, const OrbitMotion<V>& m,
                                           const MaskOf<V>& lanes) {
        const EventFunctions<V> here = system.event_functions(in_plane(system, m.from_here(system)));
        f.energy_error = select(lanes, max(f.energy_error, abs(here.excess) / here.size), f.energy_error);
    }

    /// The end of a step in space again, but for rays that have not turned.
    template <class System, class V>
    static void leave(const System& system, StepperState<V>& f, const OrbitMotion<V>& there, const V& angle,
                      const V& rest) {
        const MaskOf<V> still = abs(angle) <= V(ScalarOf<V>(0));
        const OrbitMotion<V> m = there.from_here(system);
        const State<V> here = in_plane(system, m);
        OrbitFrame<V> plane(f.start);
        plane.turn(angle, rest);
        const Vec3<V> q = here.y[component_x] * plane.out;
        const Vec3<V> p = advance(here.y[component_px] * plane.out, here.y[component_py], plane.around);
        f.end.set(select<V>(still, f.start.q(), q), select<V>(still, f.start.p(), p));
        f.end.parameter = m.parameter;
        m.leave_to(f.end), plane.leave_to(f.end);
        const Vec3<V> velocity = select<V>(still, f.start.velocity, plane.velocity(m.u, m.w));
        f.stage[0][0] = velocity.x, f.stage[0][1] = velocity.y, f.stage[0][2] = velocity.z;
        f.solved = always<V>();
    }

    /// p·q/r from −L w, which it is where p lies along the ray.
    template <class H, class System, class V>
    KAGERO_INLINE static V radial_momentum(const System& system, const V& u, const V& along, const V& l, const V& pt) {
        if constexpr (requires { H::radial_momentum(system.template parameters<V>(), u, along, l, pt); })
            return H::radial_momentum(system.template parameters<V>(), u, along, l, pt);
        else
            return along;
    }
};

}  // namespace kagero

/// Rays about a centre, in the plane of their orbit: u = 1/r as a function of the angle swept (Binet's equation). Of six
/// variables two are left, and the step is an angle, in radians, whatever the size of things.
///
///     du/dφ = w,   dw/dφ = −∂V/∂u,   dλ/dφ = 1/(u² L)
///
/// with V from the Hamiltonian's header and L = |q × p|. E = ½w² + V is constant and separable: Nyström's fractions serve it
/// (Blanes & Moan 2002). Far out 1/u² changes much in a step, but −w/u, which is λ on a straight line, takes that away:
///
///     1/u² = (d(−w/u)/dφ + (2V − u ∂V/∂u)/u²) / 2E
///
/// and the rest, a function of u alone, is what a kick adds. Start and end of a step are points of space again, for whatever is
/// met there.
#pragma once

#include "kernels/stepping/composition.h"

namespace kagero {

struct Orbit {
    static constexpr bool carries = true;  ///< L, which no place along the ray tells as well as its start
    static constexpr bool resumes = true;

    template <class System>
    static constexpr const char* refusal() {
        if (System::rescaled) return "it steps in the angle of the orbit, not in a rescaled parameter";
        return Orbiting<typename System::Hamiltonian> ? nullptr : "its Hamiltonian states no potential of the orbit plane";
    }

    template <class System, class V>
    static void begin(const System&, Flow<V>& f, const Coefficients&) {
        const Plane<V> plane(f.start, f.start_velocity);
        f.carry[0] = f.next_carry[0] = plane.across * recip(plane.u);
        f.start_velocity = plane.velocity();
        f.start_scale = f.scale = no_bound<V>();
    }

    /// The step is cut where r would change by too much: beyond it the curve in space would no longer be a smooth function of the
    /// angle.
    template <class System, class V>
    static void step(const System& system, Flow<V>& f, const Coefficients& coefficients) {
        using S = ScalarOf<V>;
        Plane<V> plane = Plane<V>::by_angle(f.start, f.start_velocity);
        const V momentum = f.next_carry[0] = f.carry[0];
        const V longest =
            plane.u * rsqrt(plane.u * plane.u + plane.w * plane.w) * pick(plane.w > V(S(0)), V(S(inward)), V(S(outward)));
        f.h = max(min(f.h, longest), -longest);
        const V pt = f.start.y[6];
        const auto twice_energy = [&] { return V(S(2)) * system.orbit().energy(plane.u, plane.w, momentum, pt); };
        const V pace = f.want_parameter ? recip(momentum * twice_energy()) : V(S(0));
        V gained = plane.w * recip(plane.u);
        bool kick = coefficients.kick_first;
        for (const double fraction : coefficients.fractions) {
            const V angle = f.h * V(S(fraction));
            if (kick) {
                const V slope = system.orbit().slope(plane.u, momentum, pt);
                if (f.want_parameter) {
                    const V rest = neg_mul_add(plane.w, plane.w, neg_mul_add(plane.u, slope, twice_energy()));
                    gained = mul_add(angle, rest * recip(plane.u * plane.u), gained);
                }
                plane.w = neg_mul_add(angle, slope, plane.w);
                f.gradients += V(S(1));
            } else {
                plane.u = mul_add(angle, plane.w, plane.u);
            }
            kick = !kick;
        }
        gained = neg_mul_add(plane.w, recip(plane.u), gained);
        plane.turn(f.h);
        const V radial = radial_momentum<typename System::Hamiltonian>(system, plane.u, -(momentum * plane.w), momentum, pt);
        const MaskOf<V> still = abs(f.h) <= V(S(0));
        f.end.set(pick<V>(still, f.start.q(), plane.position()),
                  pick<V>(still, f.start.p(), advance(radial * plane.out, momentum * plane.u, plane.around)));
        f.end_parameter = mul_add(gained, pace, f.start_parameter);
        const Vec3<V> velocity = pick<V>(still, f.start_velocity, plane.velocity());
        f.stage[0][0] = velocity.x, f.stage[0][1] = velocity.y, f.stage[0][2] = velocity.z;
        f.solved = V(S(0)) <= V(S(0));
    }

    /// After the end has been surveyed: its velocity is that along the orbit, by the angle.
    template <class V>
    KAGERO_INLINE static void arrived(Flow<V>& f) {
        f.end_velocity = {f.stage[0][0], f.stage[0][1], f.stage[0][2]};
        f.scale = no_bound<V>();
    }

private:
    /// Greatest share by which u may change in a step.
    static constexpr double outward = 0.6, inward = 1.5;
    template <class V>
    static V no_bound() {
        return V(ScalarOf<V>(std::numeric_limits<float>::max()));
    }

    /// A ray in the plane of its orbit, and where that plane lies in space.
    template <class V>
    struct Plane {
        using S = ScalarOf<V>;
        Vec3<V> out, around;  ///< unit vectors along q, and across it, the way the ray goes
        V u, w, across;       ///< 1/r, du/dφ; the velocity across the radius

        /// A ray that hardly turns is kept from being radial, by some roundings.
        KAGERO_INLINE Plane(const State<V>& s, const Vec3<V>& velocity) {
            const Vec3<V> q = s.q();
            u = rsqrt(dot(q, q));
            out = u * q;
            const V radial = dot(out, velocity);
            const Vec3<V> turning = retreat(velocity, radial, out);
            const V least = V(S(16) * machine_epsilon<S>) * radial, square = dot(turning, turning);
            const V inverse = rsqrt(max(max(square, least * least), V(S(std::numeric_limits<float>::min()))));
            around = inverse * turning;
            across = recip(inverse);
            w = -(radial * u * inverse);
        }
        /// The same where the velocity is dq/dφ: its part along the radius alone tells w, however little the ray turns.
        KAGERO_INLINE static Plane by_angle(const State<V>& s, const Vec3<V>& velocity) {
            Plane plane(s, velocity);
            plane.w = -(dot(plane.out, velocity) * plane.u * plane.u);
            return plane;
        }
        /// Both axes, by an angle.
        KAGERO_INLINE void turn(const V& angle) {
            const V c = cos(angle), s = sin(angle);
            const Vec3<V> before = out;
            out = advance(c * before, s, around);
            around = retreat(c * around, s, before);
        }
        KAGERO_INLINE Vec3<V> position() const { return recip(u) * out; }
        /// dq/dφ.
        KAGERO_INLINE Vec3<V> velocity() const {
            const V r = recip(u);
            return retreat(r * around, w * r * r, out);
        }
    };

    /// p·q/r from dr/dλ, which it is where ∂H/∂p = p.
    template <class H, class System, class V>
    KAGERO_INLINE static V radial_momentum(const System& system, const V& u, const V& speed, const V& l, const V& pt) {
        if constexpr (requires { H::radial_momentum(system.template parameters<V>(), u, speed, l, pt); })
            return H::radial_momentum(system.template parameters<V>(), u, speed, l, pt);
        else
            return speed;
    }
};

}  // namespace kagero

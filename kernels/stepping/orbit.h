/// Rays about a centre, in the plane of their orbit: u = 1/r as a function of the angle swept (Binet's equation). Of six variables two are
/// left, and the step is an angle, in radians, whatever the size of things.
///
///     du/dφ = w,   dw/dφ = −∂V/∂u,   dλ/dφ = 1/(u² L)
///
/// with V from the Hamiltonian's header and L = |q × p|. ½w² + V is separable, λ the coordinate to a constant momentum, so that Nyström's
/// fractions serve all three (Blanes & Moan 2002). Start and end of a step are points of space again, for whatever is met there.
#pragma once

#include "kernels/stepping/composition.h"

namespace kagero {

/// V(u) in the guise of a Hamiltonian of u = q.x, w = p.x and L = p.y, so that the tape differentiates it.
template <class H>
struct OrbitPlane {
    static constexpr const auto& parameters = H::parameters;
    static constexpr double level = 0;
    template <class V>
    using Parameters = typename H::template Parameters<V>;
    template <class V>
    static constexpr V energy(const Parameters<V>& k, const Vec3<V>& q, const Vec3<V>& p, const V& pt) {
        return 0.5 * p.x * p.x + H::orbit_potential(k, q.x, p.y, pt);
    }
};

template <class H, class S>
using OrbitSystem = Sides<OrbitPlane<H>, false, S>;

struct Orbit {
    template <class System>
    static constexpr const char* refusal() {
        if (System::rescaled) return "it steps in the angle of the orbit, not in a rescaled parameter";
        return Orbiting<typename System::Hamiltonian> ? nullptr : "its Hamiltonian states no potential of the orbit plane";
    }

    template <class System, class V>
    static void begin(const System&, Flow<V>& f, const Coefficients&) {
        const Plane<V> plane(f.start, f.start_velocity);
        f.start_velocity = plane.velocity();
        f.start_scale = f.scale = no_bound<V>();
    }

    /// The step is cut where r would change by too much: beyond it the curve in space would no longer be a smooth function of the angle.
    template <class System, class V>
    static void step(const System& system, Flow<V>& f, const Coefficients& coefficients) {
        using S = ScalarOf<V>;
        Plane<V> plane(f.start, f.start_velocity);
        const V longest = plane.u * rsqrt(plane.u * plane.u + plane.w * plane.w) * pick(plane.w > V(S(0)), V(S(inward)), V(S(outward)));
        f.h = max(min(f.h, longest), -longest);
        const V pt = f.start.y[6], zero(S(0));
        const V pace = recip(plane.momentum);
        V parameter = f.start_parameter;
        bool kick = coefficients.kick_first;
        for (const double fraction : coefficients.fractions) {
            const V angle = f.h * V(S(fraction));
            if (kick) {
                const State<V> here{{plane.u, zero, zero, plane.w, plane.momentum, zero, pt}};
                plane.w = neg_mul_add(angle, system.orbit().dq(here).x, plane.w);
                if (f.want_parameter) parameter = mul_add(angle, pace * recip(plane.u * plane.u), parameter);
                f.gradients += V(S(1));
            } else {
                plane.u = mul_add(angle, plane.w, plane.u);
            }
            kick = !kick;
        }
        plane.turn(f.h);
        const V radial = radial_momentum<typename System::Hamiltonian>(system, plane, pt);
        const MaskOf<V> still = f.h == zero;
        f.end.set(pick<V>(still, f.start.q(), plane.position()), pick<V>(still, f.start.p(), plane.canonical(radial)));
        f.end_parameter = parameter;
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
    static V no_bound() { return V(std::numeric_limits<ScalarOf<V>>::max()); }

    /// A ray in the plane of its orbit, and where that plane lies in space.
    template <class V>
    struct Plane {
        using S = ScalarOf<V>;
        Vec3<V> out, around;  ///< unit vectors along q, and across it, the way the ray goes
        V u, w, momentum;     ///< 1/r, du/dφ, L

        /// Only the direction of the velocity counts. That of a ray that hardly turns is kept from being radial, by a rounding or so.
        KAGERO_INLINE Plane(const State<V>& s, const Vec3<V>& velocity) {
            const Vec3<V> q = s.q();
            u = rsqrt(dot(q, q));
            out = u * q;
            const V radial = dot(out, velocity);
            const Vec3<V> across = retreat(velocity, radial, out);
            const V least = V(S(16) * machine_epsilon<S>) * abs(radial), square = dot(across, across);
            const V inverse = rsqrt(max(max(square, least * least), V(std::numeric_limits<S>::min())));
            around = inverse * across;
            w = -(radial * u * inverse);
            const V turning = dot(s.p(), around) * recip(u), forward = abs(dot(s.p(), out)) * recip(u);
            momentum = max(turning, V(S(16) * machine_epsilon<S>) * forward);
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
        KAGERO_INLINE Vec3<V> canonical(const V& radial) const { return advance(radial * out, momentum * u, around); }
    };

    /// p·q/r; dr/dλ = −L w, which it is where ∂H/∂p = p.
    template <class H, class System, class V>
    KAGERO_INLINE static V radial_momentum(const System& system, const Plane<V>& plane, const V& pt) {
        const V speed = -(plane.momentum * plane.w);
        if constexpr (requires { H::radial_momentum(system.template parameters<V>(), plane.u, speed, plane.momentum, pt); })
            return H::radial_momentum(system.template parameters<V>(), plane.u, speed, plane.momentum, pt);
        else
            return speed;
    }
};

}  // namespace kagero

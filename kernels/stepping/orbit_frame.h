/// The plane of an orbit about a centre, in space; and a ray in it, by the angle φ swept: u = 1/r and w = du/dφ.
#pragma once

#include "kernels/stepping/flow.h"

namespace kagero {

/// A ray in the plane of its orbit, and where that plane lies in space.
template <class V>
struct OrbitFrame {
    using S = ScalarOf<V>;
    Vec3<V> out, around;  ///< unit vectors along q, and across it, the way the ray goes
    V u, w, across;       ///< 1/r, du/dφ; the velocity across the radius

    /// A ray that hardly turns is kept from being radial, by some roundings.
    KAGERO_INLINE OrbitFrame(const State<V>& s, const Vec3<V>& velocity) {
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
    KAGERO_INLINE static OrbitFrame by_angle(const State<V>& s, const Vec3<V>& velocity) {
        OrbitFrame plane(s, velocity);
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
    /// dq/dφ.
    KAGERO_INLINE Vec3<V> velocity() const {
        const V r = recip(u);
        return retreat(r * around, w * r * r, out);
    }
};

/// A ray in its plane.
template <class V>
struct OrbitMotion {
    V u, w;          ///< 1/r, du/dφ
    V momentum, pt;  ///< L, p_t
    V g;             ///< 1/b²
    V parameter;     ///< λ
    MaskOf<V> far;   ///< in the universe beyond the throat, where u and w are those of its own radius
    bool want_parameter;

    template <class System>
    KAGERO_INLINE OrbitMotion(const System& system, const Flow<V>& f, const OrbitFrame<V>& plane)
        : u(plane.u), w(plane.w), momentum(f.start.carry[0]), pt(f.start.y[6]), parameter(f.start.parameter), far(u < V(ScalarOf<V>(0))),
          want_parameter(f.want_parameter) {
        g = recip(momentum * momentum);
        if constexpr (System::Hamiltonian::spacetime) g = g * (pt * pt);
        change_sides(system);
    }
    /// From now on as `next`, in these lanes.
    KAGERO_INLINE void take(const OrbitMotion& next, const MaskOf<V>& lanes) {
        u = pick(lanes, next.u, u), w = pick(lanes, next.w, w);
        if (want_parameter) parameter = pick(lanes, next.parameter, parameter);
    }
    /// Through the throat, where the ray has passed it.
    template <class System>
    KAGERO_INLINE void change_sides(const System& system) {
        if constexpr (FarSided<typename System::Hamiltonian>) {
            const MaskOf<V> through = u * u > throat(system);
            invert(system, through);
            far = (far & !through) | (through & !far);
        }
    }
    /// The same in this universe's radius.
    template <class System>
    KAGERO_INLINE OrbitMotion from_here(const System& system) const {
        OrbitMotion m = *this;
        if constexpr (FarSided<typename System::Hamiltonian>) m.invert(system, far);
        return m;
    }

private:
    /// u² there.
    template <class System>
    KAGERO_INLINE static V throat(const System& system) {
        const V radius = System::Hamiltonian::far_side(system.template parameters<V>());
        return recip(radius * radius);
    }
    template <class System>
    KAGERO_INLINE void invert(const System& system, const MaskOf<V>& lanes) {
        const V r = recip(u), other = throat(system) * r;
        u = pick(lanes, other, u), w = pick(lanes, -(w * r * other), w);
    }
};

}  // namespace kagero

/// The plane of an orbit about a centre, in space; and a ray in it, by the angle φ swept: u = 1/r and w = du/dφ.
#pragma once

#include "kernels/integrators/stepper_state.h"

namespace kagero {

/// Where RayState::carry has what the orbit knows better than the state: L; 1/r and du/dφ with what rounding cuts off
/// them; and the unit vector across the radius (3).
enum OrbitCarry { orbit_momentum, orbit_u, orbit_u_rest, orbit_w, orbit_w_rest, orbit_around, orbit_carried = orbit_around + 3 };
static_assert(orbit_carried <= stepper_memory);

/// L dλ/dφ − 1/u².
template <class System, class V>
KAGERO_INLINE V orbit_delay(const System& system, const V& u) {
    if constexpr (Delaying<typename System::Hamiltonian>)
        return System::Hamiltonian::orbit_delay(system.template parameters<V>(), u);
    else return V(ScalarOf<V>(0));
}

/// Where the plane of an orbit lies in space.
template <class V>
struct OrbitFrame {
    using S = ScalarOf<V>;
    Vec3<V> out, around;  ///< unit vectors along q, and across it, the way the ray goes

    KAGERO_INLINE explicit OrbitFrame(const RayState<V>& at) {
        const V* const carry = at.carry;
        const Vec3<V> q = at.q(), before{carry[orbit_around], carry[orbit_around + 1], carry[orbit_around + 2]};
        out = rsqrt(dot(q, q)) * q;
        const Vec3<V> across = retreat(before, dot(out, before), out);
        around = rsqrt(max(dot(across, across), V(S(std::numeric_limits<float>::min())))) * across;
    }
    /// Both axes, by an angle and what rounding has cut off it.
    KAGERO_INLINE void turn(const V& angle, const V& rest) {
        V c = cos(angle), s = sin(angle);
        if constexpr (std::is_same_v<S, float>) {
            const V cosine = fnma(rest, s, c);
            s = fma(rest, c, s), c = cosine;
        }
        const Vec3<V> before = out;
        out = advance(c * before, s, around);
        around = retreat(c * around, s, before);
    }
    KAGERO_INLINE void leave_to(RayState<V>& to) const {
        to.carry[orbit_around] = around.x, to.carry[orbit_around + 1] = around.y, to.carry[orbit_around + 2] = around.z;
    }
    /// dq/dφ of a ray with these 1/r and du/dφ.
    KAGERO_INLINE Vec3<V> velocity(const V& u, const V& w) const {
        const V r = recip(u);
        return retreat(r * around, w * r * r, out);
    }
};

/// A ray in its plane.
template <class V>
struct OrbitMotion {
    /// Whether roundings are carried along: of float they would be what a ray errs by.
    static constexpr bool compensated = std::is_same_v<ScalarOf<V>, float>;
    V u, w;            ///< 1/r, du/dφ
    V u_rest, w_rest;  ///< what rounding has cut off them
    V momentum, pt;    ///< L, p_t
    V g;               ///< 1/b²
    V parameter;       ///< λ
    MaskOf<V> far;     ///< in the universe beyond the throat, where u and w are those of its own radius
    bool want_parameter;

    template <class System>
    KAGERO_INLINE OrbitMotion(const System& system, const StepperState<V>& f)
        : u(f.start.carry[orbit_u]), w(f.start.carry[orbit_w]), u_rest(f.start.carry[orbit_u_rest]),
          w_rest(f.start.carry[orbit_w_rest]), momentum(f.start.carry[orbit_momentum]), pt(f.start.pt()),
          parameter(f.start.parameter), far(never<V>()), want_parameter(f.options.want_carried) {
        g = recip(momentum * momentum);
        if constexpr (System::Hamiltonian::spacetime) g = g * (pt * pt);
        change_sides(system);
    }
    KAGERO_INLINE void leave_to(RayState<V>& to) const {
        to.carry[orbit_momentum] = momentum;
        to.carry[orbit_u] = u, to.carry[orbit_u_rest] = u_rest, to.carry[orbit_w] = w, to.carry[orbit_w_rest] = w_rest;
    }
    /// From now on as `next`, in these lanes.
    KAGERO_INLINE void take(const OrbitMotion& next, const MaskOf<V>& lanes) {
        u = select(lanes, next.u, u), w = select(lanes, next.w, w);
        if constexpr (compensated)
            u_rest = select(lanes, next.u_rest, u_rest), w_rest = select(lanes, next.w_rest, w_rest);
        if (want_parameter) parameter = select(lanes, next.parameter, parameter);
    }
    /// Adds to a number, and keeps what rounding cuts off the sum, which is less than it.
    KAGERO_INLINE static void add(const V& more, V& sum, V& rest) {
        if constexpr (compensated) {
            const V all = more + rest, before = sum;
            sum = before + all, rest = all - (sum - before);
        } else {
            sum = sum + more;
        }
    }
    /// Through the throat, where the ray has passed it.
    template <class System>
    KAGERO_INLINE void change_sides(const System& system) {
        if constexpr (TwoSheeted<typename System::Hamiltonian>) {
            const MaskOf<V> through = u * u > throat(system);
            invert(system, through);
            far = (far & !through) | (through & !far);
        }
    }
    /// The same in this universe's radius.
    template <class System>
    KAGERO_INLINE OrbitMotion from_here(const System& system) const {
        OrbitMotion m = *this;
        if constexpr (TwoSheeted<typename System::Hamiltonian>) m.invert(system, far);
        return m;
    }

private:
    /// u² there.
    template <class System>
    KAGERO_INLINE static V throat(const System& system) {
        const V radius = System::Hamiltonian::throat_radius(system.template parameters<V>());
        return recip(radius * radius);
    }
    template <class System>
    KAGERO_INLINE void invert(const System& system, const MaskOf<V>& lanes) {
        const V r = recip(u), other = throat(system) * r;
        u = select(lanes, other, u), w = select(lanes, -(w * r * other), w);
        if constexpr (compensated)
            u_rest = select(lanes, V(ScalarOf<V>(0)), u_rest), w_rest = select(lanes, V(ScalarOf<V>(0)), w_rest);
    }
};

}  // namespace kagero

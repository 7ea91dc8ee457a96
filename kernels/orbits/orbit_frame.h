/// The orbit plane in space, and the motion of a ray in it: u = 1/r and w = du/dφ as functions of the swept angle φ.
#pragma once

#include "kernels/integrators/stepper_state.h"

namespace kagero {

/// Indices of the orbit in RayState::stepper_memory: L, u and w with their rounding errors, and the tangential unit
/// vector (3 numbers). The stored orbit is more accurate than the position and momentum of the state.
enum OrbitMemory {
    orbit_momentum,
    orbit_u,
    orbit_u_rest,
    orbit_w,
    orbit_w_rest,
    orbit_tangential,
    orbit_memory_size = orbit_tangential + 3
};
static_assert(orbit_memory_size <= stepper_memory_size);

/// Returns D(u) = L dλ/dφ − 1/u².
template <class System, class V>
KAGERO_INLINE V orbit_delay(const System& system, const V& u) {
    if constexpr (HasOrbitDelay<typename System::Hamiltonian>)
        return System::Hamiltonian::orbit_delay(system.template parameters<V>(), u);
    else return V(ScalarOf<V>(0));
}

/// The axes of the orbit plane in space.
template <class V>
struct OrbitFrame {
    using S = ScalarOf<V>;
    Vec3<V> radial, tangential;  ///< unit vectors along q, and perpendicular to it in the direction of motion

    /// Constructs the axes from the position and from the stored tangential vector, which is made orthogonal to it.
    KAGERO_INLINE explicit OrbitFrame(const RayState<V>& at) {
        const V* const stored = at.stepper_memory + orbit_tangential;
        const Vec3<V> q = at.q(), old{stored[0], stored[1], stored[2]};
        radial = rsqrt(dot(q, q)) * q;
        const Vec3<V> transverse = retreat(old, dot(radial, old), radial);
        tangential =
            rsqrt(max(dot(transverse, transverse), V(S(std::numeric_limits<float>::min())))) * transverse;
    }
    /// Rotates both axes by angle + rest, where `rest` is the rounding error of the angle.
    KAGERO_INLINE void rotate(const V& angle, const V& rest) {
        V c = cos(angle), s = sin(angle);
        if constexpr (std::is_same_v<S, float>) {
            const V cosine = fnma(rest, s, c);
            s = fma(rest, c, s);
            c = cosine;
        }
        const Vec3<V> before = radial;
        radial = advance(c * before, s, tangential);
        tangential = retreat(c * tangential, s, before);
    }
    /// Stores the tangential vector in the memory of the stepper.
    KAGERO_INLINE void store_to(RayState<V>& to) const {
        V* const stored = to.stepper_memory + orbit_tangential;
        stored[0] = tangential.x;
        stored[1] = tangential.y;
        stored[2] = tangential.z;
    }
    /// Returns dq/dφ of a ray with u = 1/r and w = du/dφ.
    KAGERO_INLINE Vec3<V> velocity(const V& u, const V& w) const {
        const V r = recip(u);
        return retreat(r * tangential, w * r * r, radial);
    }
};

/// The motion of a ray in its orbit plane.
template <class V>
struct OrbitMotion {
    /// True if u and w are summed with compensation. For float, their rounding would otherwise dominate the error of
    /// the ray.
    static constexpr bool compensated = std::is_same_v<ScalarOf<V>, float>;
    V u, w;            ///< 1/r, du/dφ
    V u_rest, w_rest;  ///< rounding errors of u and w, for compensated summation
    V momentum, pt;    ///< L, p_t
    V g;               ///< 1/b², where b is the impact parameter
    V parameter;       ///< λ
    MaskOf<V> on_second_sheet;  ///< lanes whose ray is on the second sheet; u and w refer to the radius on that sheet
    bool want_parameter;        ///< integrate λ

    template <class System>
    KAGERO_INLINE OrbitMotion(const System& system, const StepperState<V>& f)
        : u(f.start.stepper_memory[orbit_u]), w(f.start.stepper_memory[orbit_w]),
          u_rest(f.start.stepper_memory[orbit_u_rest]), w_rest(f.start.stepper_memory[orbit_w_rest]),
          momentum(f.start.stepper_memory[orbit_momentum]), pt(f.start.pt()),
          parameter(f.start.parameter), on_second_sheet(no_lanes<V>()), want_parameter(f.options.compute_carried) {
        g = recip(momentum * momentum);
        if constexpr (System::Hamiltonian::spacetime) g = g * (pt * pt);
        change_sheet(system);
    }
    /// Stores L, u and w in the memory of the stepper.
    KAGERO_INLINE void store_to(RayState<V>& to) const {
        V* const stored = to.stepper_memory;
        stored[orbit_momentum] = momentum;
        stored[orbit_u] = u;
        stored[orbit_u_rest] = u_rest;
        stored[orbit_w] = w;
        stored[orbit_w_rest] = w_rest;
    }
    /// Copies the selected lanes of `next`.
    KAGERO_INLINE void copy_lanes(const OrbitMotion& next, const MaskOf<V>& lanes) {
        u = select(lanes, next.u, u);
        w = select(lanes, next.w, w);
        if constexpr (compensated) {
            u_rest = select(lanes, next.u_rest, u_rest);
            w_rest = select(lanes, next.w_rest, w_rest);
        }
        if (want_parameter) parameter = select(lanes, next.parameter, parameter);
    }
    /// Adds a number to a sum with compensated summation. `rest` is the rounding error of the sum; its magnitude is
    /// smaller than that of the number.
    KAGERO_INLINE static void add(const V& number, V& sum, V& rest) {
        if constexpr (compensated) {
            const V all = number + rest, before = sum;
            sum = before + all;
            rest = all - (sum - before);
        } else {
            sum = sum + number;
        }
    }
    /// Switches rays that have passed the throat to the other sheet.
    template <class System>
    KAGERO_INLINE void change_sheet(const System& system) {
        if constexpr (TwoSheeted<typename System::Hamiltonian>) {
            const MaskOf<V> through = u * u > throat_u2(system);
            invert(system, through);
            on_second_sheet = (on_second_sheet & !through) | (through & !on_second_sheet);
        }
    }
    /// Returns the motion with u and w in terms of the radius on the first sheet.
    template <class System>
    KAGERO_INLINE OrbitMotion on_first_sheet(const System& system) const {
        OrbitMotion m = *this;
        if constexpr (TwoSheeted<typename System::Hamiltonian>) m.invert(system, on_second_sheet);
        return m;
    }

private:
    /// Returns u² at the throat.
    template <class System>
    KAGERO_INLINE static V throat_u2(const System& system) {
        const V radius = System::Hamiltonian::throat_radius(system.template parameters<V>());
        return recip(radius * radius);
    }
    /// Applies the inversion at the throat to u and w, in the selected lanes.
    template <class System>
    KAGERO_INLINE void invert(const System& system, const MaskOf<V>& lanes) {
        const V r = recip(u), other = throat_u2(system) * r;
        u = select(lanes, other, u);
        w = select(lanes, -(w * r * other), w);
        if constexpr (compensated) {
            u_rest = select(lanes, V(ScalarOf<V>(0)), u_rest);
            w_rest = select(lanes, V(ScalarOf<V>(0)), w_rest);
        }
    }
};

}  // namespace kagero

/// The orbit plane in space, and the motion of a ray in it: u = 1/r and w = du/dφ as functions of the swept angle φ.
#pragma once

#include "kernels/integrators/stepper_state.h"

namespace kagero {

/// Indices of the data of an orbit in RayState::stepper_memory: L, u and w, the rounding errors of u and w, and the
/// tangential unit vector (3 numbers). These data are more accurate than the position and momentum of the state.
enum OrbitMemory {
    orbit_angular_momentum,
    orbit_u,
    orbit_u_rounding,
    orbit_w,
    orbit_w_rounding,
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
    Vec3<V> radial, tangential;  ///< unit vectors along q, and perpendicular to q in the direction of motion

    /// Constructs the axes from the position and the stored tangential vector, which is made orthogonal to the
    /// position.
    KAGERO_INLINE explicit OrbitFrame(const RayState<V>& state) {
        const V* const memory = state.stepper_memory + orbit_tangential;
        const Vec3<V> q = state.q(), stored{memory[0], memory[1], memory[2]};
        radial = rsqrt(dot(q, q)) * q;
        const Vec3<V> transverse = retreat(stored, dot(radial, stored), radial);
        tangential =
            rsqrt(max(dot(transverse, transverse), V(S(std::numeric_limits<float>::min())))) * transverse;
    }
    /// Rotates both axes in the orbit plane by angle + rounding, where `rounding` is the rounding error of the angle.
    KAGERO_INLINE void rotate(const V& angle, const V& rounding) {
        V c = cos(angle), s = sin(angle);
        if constexpr (std::is_same_v<S, float>) {
            const V cosine = fnma(rounding, s, c);
            s = fma(rounding, c, s);
            c = cosine;
        }
        const Vec3<V> old_radial = radial;
        radial = advance(c * old_radial, s, tangential);
        tangential = retreat(c * tangential, s, old_radial);
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
    V u, w;                      ///< 1/r, du/dφ
    V u_rounding, w_rounding;    ///< rounding errors of u and w, for compensated summation
    V angular_momentum, pt;      ///< L, p_t
    V g;                         ///< 1/b², where b is the impact parameter
    V parameter;                 ///< λ
    MaskOf<V> on_second_sheet;   ///< lanes whose ray is on the second sheet; u and w refer to the radius on that sheet
    bool integrates_parameter;   ///< true if λ is requested

    template <class System>
    KAGERO_INLINE OrbitMotion(const System& system, const StepperState<V>& step)
        : u(step.start.stepper_memory[orbit_u]), w(step.start.stepper_memory[orbit_w]),
          u_rounding(step.start.stepper_memory[orbit_u_rounding]),
          w_rounding(step.start.stepper_memory[orbit_w_rounding]),
          angular_momentum(step.start.stepper_memory[orbit_angular_momentum]), pt(step.start.pt()),
          parameter(step.start.parameter), on_second_sheet(no_lanes<V>()),
          integrates_parameter(step.options.compute_carried) {
        g = recip(angular_momentum * angular_momentum);
        if constexpr (System::Hamiltonian::spacetime) g = g * (pt * pt);
        switch_sheet(system);
    }
    /// Stores L, u and w in the memory of the stepper.
    KAGERO_INLINE void store_to(RayState<V>& to) const {
        V* const stored = to.stepper_memory;
        stored[orbit_angular_momentum] = angular_momentum;
        stored[orbit_u] = u;
        stored[orbit_u_rounding] = u_rounding;
        stored[orbit_w] = w;
        stored[orbit_w_rounding] = w_rounding;
    }
    /// Copies u, w and λ from `next` in the given lanes.
    KAGERO_INLINE void copy_lanes(const OrbitMotion& next, const MaskOf<V>& lanes) {
        u = select(lanes, next.u, u);
        w = select(lanes, next.w, w);
        if constexpr (compensated) {
            u_rounding = select(lanes, next.u_rounding, u_rounding);
            w_rounding = select(lanes, next.w_rounding, w_rounding);
        }
        if (integrates_parameter) parameter = select(lanes, next.parameter, parameter);
    }
    /// Adds a number to a sum with compensated summation. `rounding` is the rounding error of the sum.
    KAGERO_INLINE static void add(const V& number, V& sum, V& rounding) {
        if constexpr (compensated) {
            const V increment = number + rounding, old_sum = sum;
            sum = old_sum + increment;
            rounding = increment - (sum - old_sum);
        } else {
            sum = sum + number;
        }
    }
    /// Changes the sheet of rays that have passed the throat: u and w then refer to the radius on the new sheet.
    template <class System>
    KAGERO_INLINE void switch_sheet(const System& system) {
        if constexpr (TwoSheeted<typename System::Hamiltonian>) {
            const MaskOf<V> through = u * u > throat_u2(system);
            invert(system, through);
            on_second_sheet = (on_second_sheet & !through) | (through & !on_second_sheet);
        }
    }
    /// Returns the motion with u = 1/r and w = du/dφ for the radius r = |q|, also for rays on the second sheet.
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
    /// Applies the inversion at the throat to u and w, in the given lanes.
    template <class System>
    KAGERO_INLINE void invert(const System& system, const MaskOf<V>& lanes) {
        const V r = recip(u), inverted_u = throat_u2(system) * r;
        u = select(lanes, inverted_u, u);
        w = select(lanes, -(w * r * inverted_u), w);
        if constexpr (compensated) {
            u_rounding = select(lanes, V(ScalarOf<V>(0)), u_rounding);
            w_rounding = select(lanes, V(ScalarOf<V>(0)), w_rounding);
        }
    }
};

}  // namespace kagero

/// Conversions between position and momentum of a ray and its separated motion.
///
/// In outgoing Kerr–Schild coordinates, q = M n with x + iy = (r − ia)(n_x + i n_y) and z = r n_z. The principal null
/// direction is l = ∂q/∂r = n. The vector dn/dτ of the separated motion is the part of Mᵀp perpendicular to n.
#pragma once

#include "kernels/orbits/orbit_start.h"
#include "kernels/orbits/separated_motion.h"

namespace kagero {

/// Replaces the rounding errors of q and p in start.stepper_memory by the data of the separated motion, which are
/// computed in double from q and p and these errors.
template <class System, class V>
__attribute__((noinline)) void initialise_separated_motion(const System& system, RayState<V>& start) {
    using D = typename WideLanes<V>::type;
    using H = typename System::Hamiltonian;
    constexpr int lanes = lane_count<V>, lanes_per_group = lane_count<D>;
    alignas(64) double state[state_size][lanes], rounding[phase_size][lanes], memory[separated_memory_size][lanes];
    for (int k = 0; k < state_size; ++k) to_doubles(start.y[k], state[k]);
    for (int k = 0; k < phase_size; ++k) to_doubles(start.stepper_memory[k], rounding[k]);
    const SeparatedHole<D> hole(system);
    for (int i = 0; i < lanes; i += lanes_per_group) {
        const auto corrected = [&](int k) { return lanes_of<D>(state[k] + i) + lanes_of<D>(rounding[k] + i); };
        const Vec3<D> q{corrected(component_x), corrected(component_y), corrected(component_z)};
        const Vec3<D> p{corrected(component_px), corrected(component_py), corrected(component_pz)};
        const D pt = lanes_of<D>(state[component_pt] + i);
        const D r = H::radius(system.template parameters<D>(), q), w = recip(r), &a = hole.a,
                inverse = recip(fma(r, r, hole.a2));
        const Vec3<D> n{inverse * (r * q.x - a * q.y), inverse * (r * q.y + a * q.x), w * q.z};
        const Vec3<D> conjugate{r * p.x - a * p.y, r * p.y + a * p.x, r * p.z};  // Mᵀp
        const Vec3<D> n_rate = conjugate - dot(n, conjugate) * n;
        const D angular_momentum = q.x * p.y - q.y * p.x;
        const D sum = hole.twice_mass * w * pt + a * angular_momentum * (w * w);
        const D w_rate = fnma(hole.delta(w), dot(n, p), sum);
        const D numbers[separated_memory_size] = {w, w_rate, n.x, n.y, n.z, n_rate.x, n_rate.y, n_rate.z};
        for (int k = 0; k < separated_memory_size; ++k) to_doubles(numbers[k], memory[k] + i);
    }
    for (int k = 0; k < separated_memory_size; ++k) start.stepper_memory[k] = lanes_of<V>(memory[k]);
}

/// Returns the motion of w from the memory of the stepper.
template <class V>
KAGERO_INLINE RadialMotion<V> radial_motion_of(const RayState<V>& state) {
    const V zero(ScalarOf<V>(0)), &w = state.stepper_memory[separated_w];
    return {w, state.stepper_memory[separated_w_rate], zero, zero, zero, w, zero};
}
/// Returns the motion of n from the memory of the stepper.
template <class V>
KAGERO_INLINE AngularMotion<V> angular_motion_of(const RayState<V>& state) {
    const V* const m = state.stepper_memory;
    return {{m[separated_n], m[separated_n + 1], m[separated_n + 2]},
            {m[separated_n_rate], m[separated_n_rate + 1], m[separated_n_rate + 2]},
            V(ScalarOf<V>(0))};
}

/// Position, momentum and dq/dτ of a ray.
template <class V>
struct SeparatedPoint {
    Vec3<V> q, p, velocity;

    /// Computes the point from w, dw/dτ, n and dn/dτ, where the azimuth of n is that of the coordinates.
    KAGERO_INLINE SeparatedPoint(const SeparatedConstants<V>& c, const V& w, const V& w_rate, const Vec3<V>& n,
                                 const Vec3<V>& n_rate) {
        using S = ScalarOf<V>;
        const V one(S(1)), r = recip(w), &a = c.hole.a, aw = a * w, g = recip(fma(aw, aw, one));
        // Mv of a vector v.
        const auto map = [&](const Vec3<V>& v) { return Vec3<V>{r * v.x + a * v.y, r * v.y - a * v.x, r * v.z}; };
        // The inverse of Mᵀ, times a vector v.
        const auto inverse_transpose = [&](const Vec3<V>& v) {
            return Vec3<V>{g * w * (v.x + aw * v.y), g * w * (v.y - aw * v.x), w * v.z};
        };
        q = map(n);
        // p = N (dn/dτ + x n) with N = M⁻ᵀ, where x is such that n·p = u − p_t with u = p_t + l·p.
        const V u = c.null_component(w, w_rate), radial = u - c.pt;
        const Vec3<V> transverse = inverse_transpose(n_rate), along = inverse_transpose(n);
        const V x = (radial - dot(n, transverse)) / dot(n, along);
        p = advance(transverse, x, along);
        const V turn = a * radial;  // the coordinates turn by −turn about the axis, per τ
        velocity = map({fma(turn, n.y, n_rate.x), fnma(turn, n.x, n_rate.y), n_rate.z});
        velocity = retreat(velocity, w_rate * (r * r), n);
    }
};

}  // namespace kagero

/// Conversion of ray starts to motions in the orbit plane, in double precision for packets of every precision. In
/// float, the error of the impact parameter would be the rounding error of the direction times the distance from the
/// centre, which is large for rays that start far out.
#pragma once

#include "kernels/orbits/orbit_frame.h"

namespace kagero {

/// The value type with lanes of type double that has as many registers as V.
template <class V>
struct WideLanes {
    using type = Lanes<double, ValueTraits<V>::registers>;
};
template <Scalar V>
struct WideLanes<V> {
    using type = double;
};

/// Replaces the rounding errors of q and p in start.stepper_memory by the data of the orbit (OrbitMemory), which are
/// computed from q and p and these errors.
///
/// L = |q × p|, and du/dφ = −u² dr/dλ dλ/dφ with dr/dλ = ∂H/∂p_r. L has a lower bound, so that r²/L of radial rays
/// stays within the range of the packet's number type. Relative to r |p|, the bound is 16 machine epsilons of double,
/// or 1/64 of the machine epsilon of float for packets of float.
template <class System, class V>
__attribute__((noinline)) void initialise_orbit(const System& system, RayState<V>& start) {
    using D = typename WideLanes<V>::type;
    constexpr int orbit_size = 3 + space_size;  // L, 1/r, du/dφ and the tangential unit vector
    constexpr int lanes = lane_count<V>, lanes_per_group = lane_count<D>;
    alignas(64) double state[state_size][lanes], rounding[phase_size][lanes], orbit[orbit_size][lanes];
    for (int k = 0; k < state_size; ++k) to_doubles(start.y[k], state[k]);
    for (int k = 0; k < phase_size; ++k) to_doubles(start.stepper_memory[k], rounding[k]);
    for (int i = 0; i < lanes; i += lanes_per_group) {
        const auto corrected = [&](int k) { return lanes_of<D>(state[k] + i) + lanes_of<D>(rounding[k] + i); };
        const Vec3<D> q{corrected(component_x), corrected(component_y), corrected(component_z)};
        const Vec3<D> p{corrected(component_px), corrected(component_py), corrected(component_pz)};
        const D u = rsqrt(dot(q, q)), r = recip(u), zero(0.0), p2 = dot(p, p);
        const Vec3<D> radial = u * q, q_cross_p = cross(q, p);
        const double relative_bound = std::max(16 * machine_epsilon<double>, double(machine_epsilon<ScalarOf<V>>) / 64),
                     smallest_normal = std::numeric_limits<float>::min();
        // A lower bound of L².
        const D lower_bound = p2 * max(relative_bound * relative_bound * (r * r), D(smallest_normal));
        const D angular_momentum = sqrt(max(dot(q_cross_p, q_cross_p), lower_bound));
        const Vec3<D> tangential = recip(angular_momentum) * cross(q_cross_p, radial);
        const D pt = lanes_of<D>(state[component_pt] + i);
        const State<D> in_plane{{r, zero, zero, dot(radial, p), angular_momentum * u, zero, pt}};
        const D dr_dlambda = system.gradient_p(in_plane).x;
        const D w = -(dr_dlambda * fma(u * u, orbit_delay(system, u), D(1.0)) * recip(angular_momentum));
        const D numbers[orbit_size] = {angular_momentum, u, w, tangential.x, tangential.y, tangential.z};
        for (int k = 0; k < orbit_size; ++k) to_doubles(numbers[k], orbit[k] + i);
    }
    V* const to = start.stepper_memory;
    V unused;
    to[orbit_angular_momentum] = lanes_of(orbit[0], unused);
    to[orbit_u] = lanes_of(orbit[1], to[orbit_u_rounding]);
    to[orbit_w] = lanes_of(orbit[2], to[orbit_w_rounding]);
    for (int k = 0; k < space_size; ++k) to[orbit_tangential + k] = lanes_of(orbit[3 + k], unused);
}

}  // namespace kagero

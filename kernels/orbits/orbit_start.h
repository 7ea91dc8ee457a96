/// Conversion of ray starts to orbits, in double precision for packets of every precision. In float, the error of the
/// impact parameter of a ray that starts far out would be the rounding error of its direction times the distance.
#pragma once

#include "kernels/orbits/orbit_frame.h"

namespace kagero {

/// The value type with double lanes that has as many registers as V.
template <class V>
struct WideLanes {
    using type = Lanes<double, ValueTraits<V>::registers>;
};
template <Scalar V>
struct WideLanes<V> {
    using type = double;
};

/// Fills `start.stepper_memory` according to OrbitMemory, from the state and the rounding errors of q and p.
///
/// L = |q × p|, and du/dφ = −u² dr/dλ dλ/dφ with dr/dλ = ∂H/∂p_r. L has a lower bound, so that r²/L of radial rays
/// stays within the range of the packet's number type. Relative to r |p|, the bound is 16 machine epsilons of double,
/// or 1/64 of the machine epsilon of float for packets of float.
template <class System, class V>
__attribute__((noinline)) void enter_orbit(const System& system, RayState<V>& start) {
    using D = typename WideLanes<V>::type;
    constexpr int numbers_of_orbit = 3 + space_size;  // L, 1/r, du/dφ and the tangential unit vector
    constexpr int lanes = lane_count<V>, together = lane_count<D>;
    alignas(64) double state[state_size][lanes], rest[phase_size][lanes], orbit[numbers_of_orbit][lanes];
    for (int k = 0; k < state_size; ++k) to_doubles(start.y[k], state[k]);
    for (int k = 0; k < phase_size; ++k) to_doubles(start.stepper_memory[k], rest[k]);
    for (int i = 0; i < lanes; i += together) {
        const auto number = [&](int k) { return lanes_of<D>(state[k] + i) + lanes_of<D>(rest[k] + i); };
        const Vec3<D> q{number(component_x), number(component_y), number(component_z)};
        const Vec3<D> p{number(component_px), number(component_py), number(component_pz)};
        const D u = rsqrt(dot(q, q)), r = recip(u), zero(0.0), square = dot(p, p);
        const Vec3<D> radial = u * q, angular = cross(q, p);
        const double relative = std::max(16 * machine_epsilon<double>, double(machine_epsilon<ScalarOf<V>>) / 64),
                     least = std::numeric_limits<float>::min();
        const D lower_bound = square * max(relative * relative * (r * r), D(least));  // on L²
        const D momentum = sqrt(max(dot(angular, angular), lower_bound));
        const Vec3<D> tangential = recip(momentum) * cross(angular, radial);
        const D pt = lanes_of<D>(state[component_pt] + i);
        const D speed = system.dp(State<D>{{r, zero, zero, dot(radial, p), momentum * u, zero, pt}}).x;
        const D w = -(speed * fma(u * u, orbit_delay(system, u), D(1.0)) * recip(momentum));
        const D numbers[numbers_of_orbit] = {momentum, u, w, tangential.x, tangential.y, tangential.z};
        for (int k = 0; k < numbers_of_orbit; ++k) to_doubles(numbers[k], orbit[k] + i);
    }
    V* const to = start.stepper_memory;
    V unused;
    to[orbit_momentum] = lanes_of(orbit[0], unused);
    to[orbit_u] = lanes_of(orbit[1], to[orbit_u_rest]);
    to[orbit_w] = lanes_of(orbit[2], to[orbit_w_rest]);
    for (int k = 0; k < space_size; ++k) to[orbit_tangential + k] = lanes_of(orbit[3 + k], unused);
}

}  // namespace kagero

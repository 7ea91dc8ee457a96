/// Rays into the plane of their orbit, once, where they start: in double whatever the packet's numbers are. A packet of
/// float that starts far out would else not know how far from the centre its rays pass: their direction alone tells,
/// and rounding it costs as many digits as the distance is greater.
#pragma once

#include "kernels/orbits/orbit_frame.h"

namespace kagero {

/// Doubles in as many registers as V has.
template <class V>
struct WideLanes {
    using type = Lanes<double, ValueTraits<V>::registers>;
};
template <Scalar V>
struct WideLanes<V> {
    using type = double;
};

/// Fills `start.carry` as OrbitCarry says, from the state and what rounding has cut off q and p.
///
/// L = |q × p|, and du/dφ = −u² dr/dλ dλ/dφ with dr/dλ = ∂H/∂p_r. A ray along the radius is kept from being just that,
/// by some roundings of double, or in float by a fraction of one: r²/L has to fit the packet's numbers.
template <class System, class V>
__attribute__((noinline)) void enter_orbit(const System& system, RayState<V>& start) {
    using D = typename WideLanes<V>::type;
    constexpr int numbers_of_orbit = 3 + space_size;  // L, 1/r and du/dφ, and the unit vector across the radius
    constexpr int lanes = lane_count<V>, together = lane_count<D>;
    alignas(64) double state[state_size][lanes], cut[phase_size][lanes], carry[numbers_of_orbit][lanes];
    for (int k = 0; k < state_size; ++k) to_doubles(start.y[k], state[k]);
    for (int k = 0; k < phase_size; ++k) to_doubles(start.carry[k], cut[k]);
    for (int i = 0; i < lanes; i += together) {
        const auto number = [&](int k) { return lanes_of<D>(state[k] + i) + lanes_of<D>(cut[k] + i); };
        const Vec3<D> q{number(component_x), number(component_y), number(component_z)};
        const Vec3<D> p{number(component_px), number(component_py), number(component_pz)};
        const D u = rsqrt(dot(q, q)), r = recip(u), zero(0.0), square = dot(p, p);
        const Vec3<D> out = u * q, spin = cross(q, p);
        const double share = std::max(16 * machine_epsilon<double>, double(machine_epsilon<ScalarOf<V>>) / 64),
                     least = std::numeric_limits<float>::min();
        const D momentum = sqrt(max(dot(spin, spin), square * max(share * share * (r * r), D(least))));
        const Vec3<D> around = recip(momentum) * cross(spin, out);
        const D pt = lanes_of<D>(state[component_pt] + i);
        const D speed = system.dp(State<D>{{r, zero, zero, dot(out, p), momentum * u, zero, pt}}).x;
        const D w = -(speed * fma(u * u, orbit_delay(system, u), D(1.0)) * recip(momentum));
        const D numbers[numbers_of_orbit] = {momentum, u, w, around.x, around.y, around.z};
        for (int k = 0; k < numbers_of_orbit; ++k) to_doubles(numbers[k], carry[k] + i);
    }
    V* const to = start.carry;
    V unused;
    to[orbit_momentum] = lanes_of(carry[0], unused);
    to[orbit_u] = lanes_of(carry[1], to[orbit_u_rest]), to[orbit_w] = lanes_of(carry[2], to[orbit_w_rest]);
    for (int k = 0; k < space_size; ++k) to[orbit_around + k] = lanes_of(carry[3 + k], unused);
}

}  // namespace kagero

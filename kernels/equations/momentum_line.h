/// H along a line in momentum space, from the tape of H. Surfaces change the momentum of a ray only along their normal,
/// so that the values of H on this line determine how the ray continues.
#pragma once

#include "kernels/equations/system.h"

namespace kagero {

/// H − H0 and ∂H/∂p at a momentum, and the derivative of ∂H/∂p along a vector n.
template <class V>
struct MomentumLine {
    V value;
    Vec3<V> velocity, change;
};

/// Systems whose ∂K/∂p is evaluated with dual numbers of another size than one.
template <class System>
concept DefinesVelocityAlong = requires(const System& system, const State<double>& s, const Vec3<double>& n) {
    system.velocity_along(s, n);
};

/// Returns ∂K/∂p and its derivative along n.
template <class System, class V>
Vec3<Dual<V, 1>> velocity_along(const System& system, const State<V>& s, const Vec3<V>& n) {
    if constexpr (DefinesVelocityAlong<System>) {
        return system.velocity_along(s, n);
    } else {
        using DualNumber = Dual<V, 1>;
        State<DualNumber> line;
        for (int k = 0; k < state_size; ++k) line.y[k] = DualNumber(s.y[k]);
        line.y[component_px].derivative[0] = n.x;
        line.y[component_py].derivative[0] = n.y;
        line.y[component_pz].derivative[0] = n.z;
        return system.gradient_p(line);
    }
}

/// Returns the expansion of H, without the factor Ω, at the momentum of s along n. The function is not inlined, because
/// it is called only at surfaces.
template <class System, class V>
__attribute__((noinline)) MomentumLine<V> momentum_line(const System& system, const State<V>& s, const Vec3<V>& n) {
    const Vec3<Dual<V, 1>> v = velocity_along(system, s, n);
    const V inverse = recip(system.time_rescaling_factor(s));
    return {system.unscaled_energy_residual(s),
            {v.x.value * inverse, v.y.value * inverse, v.z.value * inverse},
            {v.x.derivative[0] * inverse, v.y.derivative[0] * inverse, v.z.derivative[0] * inverse}};
}

}  // namespace kagero

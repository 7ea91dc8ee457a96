/// The canonical state of a ray, and names for its dimensions and indices.
#pragma once

#include "kernels/numeric/vec.h"
#include "kernels/simd/registers.h"

namespace kagero {

inline constexpr int space_size = 3;               ///< Components of a position: x y z.
inline constexpr int phase_size = 2 * space_size;  ///< Components of a point in phase space: x y z px py pz.
inline constexpr int state_size = phase_size + 1;  ///< Components of a state: phase space and the constant pt.

/// The indices of the components of a state. The components of gradients ∂K/∂(q, p) have the same order.
enum Component : int { component_x, component_y, component_z, component_px, component_py, component_pz, component_pt };
/// Returns the index, in a state, of component k of the momentum (0 ≤ k < 3).
constexpr int momentum(int k) { return space_size + k; }
/// Returns the index of the component conjugate to component k: the momentum of a position, or the reverse.
constexpr int conjugate(int k) { return k < space_size ? k + space_size : k - space_size; }

/// The gradient ∂K/∂(q, p).
template <class V>
using PhaseGradient = V[phase_size];
/// The second derivatives ∂²K/∂(q, p)², row by row.
template <class V>
using Hessian = V[phase_size * phase_size];
/// Returns the index of the second derivative with respect to components `row` and `column` in a `Hessian`.
constexpr int hessian_index(int row, int column) { return phase_size * row + column; }

/// Returns the part ∂K/∂q of a gradient; dp/dτ is the negative of this vector.
template <class V>
KAGERO_INLINE Vec3<V> force_in(const PhaseGradient<V>& g) { return {g[component_x], g[component_y], g[component_z]}; }
/// Returns the part ∂K/∂p = dq/dτ of a gradient.
template <class V>
KAGERO_INLINE Vec3<V> velocity_in(const PhaseGradient<V>& g) {
    return {g[component_px], g[component_py], g[component_pz]};
}

/// Number of carried quantities of a system that carries only λ, which is the default (see carried_in).
inline constexpr int default_carried = 1;

/// The canonical state of rays: position q, momentum p, and the constant p_t, in the order of `Component`.
template <class V>
struct State {
    V y[state_size];
    Vec3<V> q() const { return {y[component_x], y[component_y], y[component_z]}; }
    Vec3<V> p() const { return {y[component_px], y[component_py], y[component_pz]}; }
    const V& pt() const { return y[component_pt]; }
    V& pt() { return y[component_pt]; }
    /// Sets position and momentum; p_t is unchanged.
    void set(const Vec3<V>& q, const Vec3<V>& p) {
        y[component_x] = q.x;
        y[component_y] = q.y;
        y[component_z] = q.z;
        y[component_px] = p.x;
        y[component_py] = p.y;
        y[component_pz] = p.z;
    }
};

}  // namespace kagero

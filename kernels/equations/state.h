/// The canonical state of rays, and the names of its parts.
#pragma once

#include "kernels/numeric/vec.h"
#include "kernels/simd/registers.h"

namespace kagero {

inline constexpr int space_size = 3;               ///< x y z
inline constexpr int phase_size = 2 * space_size;  ///< x y z px py pz: the components that Hamilton's equations move
inline constexpr int state_size = phase_size + 1;  ///< the phase and the constant pt: the inputs of every program of H

/// Where the components of a state are. Gradients ∂K/∂(q, p) have their components in the same order.
enum Component : int { component_x, component_y, component_z, component_px, component_py, component_pz, component_pt };
/// The component of momentum k.
constexpr int momentum(int k) { return space_size + k; }
/// The component that Hamilton's equations pair with component k: the momentum of a position, or the reverse.
constexpr int conjugate(int k) { return k < space_size ? k + space_size : k - space_size; }

/// ∂K/∂(q, p).
template <class V>
using PhaseGradient = V[phase_size];
/// ∂²K/∂(q, p)², row by row.
template <class V>
using Hessian = V[phase_size * phase_size];
constexpr int hessian_index(int row, int column) { return phase_size * row + column; }

/// ∂K/∂q and ∂K/∂p of a gradient.
template <class V>
KAGERO_INLINE Vec3<V> force_in(const PhaseGradient<V>& g) { return {g[component_x], g[component_y], g[component_z]}; }
template <class V>
KAGERO_INLINE Vec3<V> velocity_in(const PhaseGradient<V>& g) {
    return {g[component_px], g[component_py], g[component_pz]};
}

/// How many quantities a ray carries along beside its state, each an integral over τ: λ alone. `System::carried` and
/// `System::carried_rates` state further ones.
inline constexpr int default_carried = 1;

/// Canonical state of rays: position q, momentum p, and the constant p_t behind them.
template <class V>
struct State {
    V y[state_size];
    Vec3<V> q() const { return {y[component_x], y[component_y], y[component_z]}; }
    Vec3<V> p() const { return {y[component_px], y[component_py], y[component_pz]}; }
    const V& pt() const { return y[component_pt]; }
    V& pt() { return y[component_pt]; }
    void set(const Vec3<V>& q, const Vec3<V>& p) {
        y[component_x] = q.x, y[component_y] = q.y, y[component_z] = q.z;
        y[component_px] = p.x, y[component_py] = p.y, y[component_pz] = p.z;
    }
};

}  // namespace kagero

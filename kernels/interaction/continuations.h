/// Momenta of rays that continue at surfaces, packet by packet (normal_momentum.h).
#pragma once

#include "kernels/abi.h"
#include "kernels/equations/momentum_line.h"
#include "kernels/interaction/normal_momentum.h"
#include "kernels/methods/space_kernel.h"

#include <algorithm>

namespace kagero {

/// The rays of one packet as lanes.
template <class V>
struct SurfaceLanes {
    State<V> state;
    Vec3<V> normal;
    std::uint64_t may_keep_value = 0;  ///< Lanes with SurfaceRay::may_keep_value.

    /// Loads `count` ≤ lane_count<V> rays. Other lanes get a copy of the last ray.
    SurfaceLanes(const SurfaceRay* rays, int count) {
        constexpr int W = lane_count<V>;
        alignas(64) double numbers[state_size + space_size][W];
        for (int i = 0; i < W; ++i) {
            const SurfaceRay& ray = rays[std::min(i, count - 1)];
            for (int k = 0; k < space_size; ++k) {
                numbers[k][i] = ray.q[k];
                numbers[momentum(k)][i] = ray.p[k];
                numbers[state_size + k][i] = ray.normal[k];
            }
            numbers[component_pt][i] = ray.pt;
            may_keep_value |= std::uint64_t(ray.may_keep_value) << i;
        }
        for (int k = 0; k < state_size; ++k) state.y[k] = lanes_of<V>(numbers[k]);
        normal = {lanes_of<V>(numbers[state_size]), lanes_of<V>(numbers[state_size + 1]),
                  lanes_of<V>(numbers[state_size + 2])};
    }
};

/// Computes the continuations of the rays of one packet.
template <class V>
void continue_packet(const SpaceKernel<V>& kernel, const SystemStorage& system, const SurfaceRay* rays, int count,
                     Continuation* out) {
    using S = ScalarOf<V>;
    const SurfaceLanes<V> lanes(rays, count);
    const Vec3<V>& n = lanes.normal;
    const auto momentum_at = [&](const V& s) { return advance(lanes.state.p(), s, n); };
    V value(S(0));     // of H − H0 after the surface
    Vec3<V> velocity;  // of the last evaluation, which is that of the solution
    const auto at = [&](const V& s) -> NormalLine<V> {
        State<V> state = lanes.state;
        state.set(state.q(), momentum_at(s));
        const MomentumLine<V> line = kernel.momentum_line(system, state, n);
        velocity = line.velocity;
        return {line.value - value, dot(n, velocity), dot(n, line.change)};
    };
    const V length = norm(lanes.state.p());
    const NormalMomentumSolver<V, decltype(at)> solver(at, select(length > V(S(0)), length, V(S(1))));
    NormalMomentum<V> solution = solver.solve();
    if (const std::uint64_t kept = lanes.may_keep_value & ~to_bits(solution.exists)) {
        value = select(from_bits<V>(kept), at(V(S(0))).value, value);
        solution = solver.solve();
    }
    const Vec3<V> p = momentum_at(solution.alpha);
    const std::uint64_t exists = to_bits(solution.exists);
    for (int i = 0; i < count; ++i)
        out[i] = {{double(get_lane(p.x, i)), double(get_lane(p.y, i)), double(get_lane(p.z, i))},
                  {double(get_lane(velocity.x, i)), double(get_lane(velocity.y, i)), double(get_lane(velocity.z, i))},
                  double(get_lane(solution.curvature, i)),
                  ((exists >> i) & 1) != 0};
}

/// Computes the tilts of the rays of one packet (Module::time_tilts). H = ½ p·γ p + p_t b·p + … has the velocity
/// γ p + p_t b, and g_ti/g_tt = −(γ⁻¹ b)_i, from the inverse of the metric in blocks. γ⁻¹ is the adjugate of γ divided
/// by its determinant.
template <class V>
void tilt_packet(const SpaceKernel<V>& kernel, const SystemStorage& system, const SurfaceRay* rays, int count,
                 double (*out)[3]) {
    using S = ScalarOf<V>;
    const SurfaceLanes<V> lanes(rays, count);
    const V zero(S(0)), one(S(1));
    const MomentumLine<V> along_x = kernel.momentum_line(system, lanes.state, {one, zero, zero});
    const Vec3<V> x = along_x.change, y = kernel.momentum_line(system, lanes.state, {zero, one, zero}).change,
                  z = kernel.momentum_line(system, lanes.state, {zero, zero, one}).change, p = lanes.state.p();
    const Vec3<V> b{along_x.velocity.x - dot(x, p), along_x.velocity.y - dot(y, p), along_x.velocity.z - dot(z, p)};
    const Vec3<V> yz = cross(y, z), zx = cross(z, x), xy = cross(x, y);
    const V factor = -one / dot(x, yz);
    const Vec3<V> tilt{factor * dot(yz, b), factor * dot(zx, b), factor * dot(xy, b)};
    for (int i = 0; i < count; ++i) {
        out[i][0] = double(get_lane(tilt.x, i));
        out[i][1] = double(get_lane(tilt.y, i));
        out[i][2] = double(get_lane(tilt.z, i));
    }
}

/// Calls compute(kernel, system, rays, count, out) for each packet of a list of rays in one space.
template <class V, class Result, class Compute>
void for_each_packet(const SpaceKernel<V>& kernel, const double* parameters, const SurfaceRay* rays,
                     std::uint32_t count, Result* out, const Compute& compute) {
    constexpr std::uint32_t W = lane_count<V>;
    SystemStorage system;
    kernel.construct(system, parameters);
    for (std::uint32_t i = 0; i < count; i += W)
        compute(kernel, system, rays + i, int(std::min(W, count - i)), out + i);
}

/// The functions of Module with these names.
void continue_rays(std::uint32_t hamiltonian, const double* parameters, const SurfaceRay* rays, std::uint32_t count,
                   Continuation* out);
void time_tilts(std::uint32_t hamiltonian, const double* parameters, const SurfaceRay* rays, std::uint32_t count,
                double (*out)[3]);

}  // namespace kagero

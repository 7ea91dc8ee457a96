/// The two charts of a spinning black hole: Kerr–Schild coordinates in the outgoing and in the ingoing form.
///
/// Scenes are in outgoing coordinates outside the horizon, and in ingoing coordinates inside it. A ray that is followed
/// backward in time and moves inward is regular in outgoing coordinates; near the horizon, a ray that moves outward is
/// regular only in ingoing coordinates. With the Boyer–Lindquist time t and azimuth φ (Kerr 1963; Visser 2007, §1.7),
///
///     outgoing: dt' = dt − (2Mr/Δ) dr,  dφ' = dφ − (a/Δ) dr,  x + iy = (r − ia) sin θ exp(iφ')
///     ingoing:  dt' = dt + (2Mr/Δ) dr,  dφ' = dφ + (a/Δ) dr,  x + iy = (r + ia) sin θ exp(iφ')
///
/// r, θ and z are the same in both, and the azimuths agree at infinity. The outgoing position is therefore the ingoing
/// one, rotated about the z axis by
///
///     ψ(r) = 2a ∫_r^∞ dr/Δ − 2 arctan(a/r),   dψ/dr = −4aMr/(Δ (r² + a²)),   Δ = r² − 2Mr + a²
///
/// and the momenta are related by p_out = Rot(ψ) p_in + (4Mr/Δ)(p_t + aL/(r² + a²)) ∇r with L = x p_y − y p_x.
///
/// Kernels follow rays in ingoing coordinates with the same Hamiltonian. The reflection y → −y together with the time
/// reversal t → −t maps the ingoing form onto the outgoing form with the same spin. The kernel's state of such a ray is
/// (x, −y, z, p_x, −p_y, p_z, −p_t). Without spin, positions are the same in both forms, and y is not reflected.
#pragma once

#include "kernels/abi.h"

#include <algorithm>
#include <cmath>

namespace kagero::charts {

/// A position and a momentum, and optionally the direction of dq/dλ.
struct State {
    double q[3], p[3], v[3], pt;
};

/// Returns the radius r₊ of the outer horizon; M if |a| > M.
inline double horizon_radius(const Hole& hole) {
    return hole.mass + std::sqrt(std::max(hole.mass * hole.mass - hole.spin * hole.spin, 0.0));
}
/// Returns |q| of the horizon on the equator, the greatest |q| of the horizon.
inline double horizon_extent(const Hole& hole) { return std::hypot(horizon_radius(hole), hole.spin); }

/// Returns the Boyer–Lindquist radius r of a position in either chart.
inline double radius(const Hole& hole, const double (&q)[3]) {
    const double a2 = hole.spin * hole.spin, b = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] - a2,
                 root = std::sqrt(b * b + 4 * a2 * q[2] * q[2]);
    return b >= 0 ? std::sqrt(0.5 * (b + root)) : std::abs(hole.spin * q[2]) * std::sqrt(2 / (root - b));
}
/// True if the position is inside the horizon or on it. Such a position is in ingoing coordinates.
inline bool is_inside(const Hole& hole, const double (&q)[3]) {
    return hole.mass > 0 && radius(hole, q) <= horizon_radius(hole);
}

/// Returns the angle ψ(r) from the ingoing to the outgoing position; r > r₊.
inline double azimuth_shift(const Hole& hole, double r) {
    if (hole.spin == 0) return 0;
    const double outer = horizon_radius(hole), difference = 2 * (outer - hole.mass), above = r - outer;
    // ∫_r^∞ dr/Δ = ln(1 + (r₊ − r₋)/(r − r₊))/(r₊ − r₋), whose limit for r₊ = r₋ is 1/(r − r₊).
    const double integral =
        difference > 1e-12 * outer ? std::log1p(difference / above) / difference : 1 / above;
    return 2 * (hole.spin * integral - std::atan2(hole.spin, r));
}

/// Rotates a vector about the z axis.
inline void rotate(double (&v)[3], double angle) {
    const double c = std::cos(angle), s = std::sin(angle), x = v[0];
    v[0] = c * x - s * v[1];
    v[1] = s * x + c * v[1];
}

/// Converts a state between the charts. `sign` is 1 from ingoing to outgoing coordinates, and −1 for the reverse.
inline void convert(const Hole& hole, State& state, double sign) {
    double(&q)[3] = state.q;
    const double r = radius(hole, q), r2 = r * r, a = hole.spin, above = r - horizon_radius(hole),
                 delta = above * (r - 2 * hole.mass + horizon_radius(hole)), sum = r2 + a * a;
    const double angle = sign * azimuth_shift(hole, r), l = q[0] * state.p[1] - q[1] * state.p[0];
    rotate(q, angle);
    rotate(state.p, angle);
    rotate(state.v, angle);
    const double scale = r / (r2 * r2 + a * a * q[2] * q[2]),
                 gradient[3] = {scale * r2 * q[0], scale * r2 * q[1], scale * (r2 + a * a) * q[2]};
    const double time_rate = 4 * hole.mass * r / delta;  // d(t_in − t_out)/dr
    const double shift = sign * time_rate * (state.pt + a * l / sum);
    const double radial_speed = gradient[0] * state.v[0] + gradient[1] * state.v[1] + gradient[2] * state.v[2],
                 turn = -sign * time_rate * a / sum * radial_speed;
    for (int k = 0; k < 3; ++k) state.p[k] += shift * gradient[k];
    const double x = q[0], y = q[1];
    state.v[0] -= turn * y;
    state.v[1] += turn * x;
    const double length = std::hypot(state.v[0], state.v[1], state.v[2]);
    if (length > 0 && std::isfinite(length))
        for (double& component : state.v) component /= length;
}

/// Converts between a state in ingoing coordinates and the state with which a kernel follows it. The conversion is its
/// own inverse.
inline void reflect(const Hole& hole, State& state) {
    state.pt = -state.pt;
    if (hole.spin == 0) return;
    state.q[1] = -state.q[1];
    state.p[1] = -state.p[1];
    state.v[1] = -state.v[1];
}

/// Converts the kernel's state of a ray in ingoing coordinates to the coordinates of the scene: outgoing coordinates,
/// or ingoing ones inside the horizon.
inline void to_scene(const Hole& hole, State& state) {
    reflect(hole, state);
    if (!is_inside(hole, state.q)) convert(hole, state, 1);
}
/// Converts a state in outgoing coordinates to the kernel's state in ingoing coordinates.
inline void to_ingoing(const Hole& hole, State& state) {
    convert(hole, state, -1);
    reflect(hole, state);
}

/// Returns F(r) with t_in − t_out = F(r) + constant, from dF/dr = 4Mr/Δ; NaN inside the horizon.
inline double time_shift(const Hole& hole, double r) {
    const double outer = horizon_radius(hole), inner = 2 * hole.mass - outer, difference = outer - inner;
    if (difference > 1e-12 * outer)
        return 4 * hole.mass / difference * (outer * std::log(r - outer) - inner * std::log(r - inner));
    return 4 * hole.mass * (std::log(r - outer) - hole.mass / (r - outer));
}
/// Convert the integrals along a ray (kernels/trace/path_integrals.h) between the charts at the radius r. `pt` is p_t
/// in either chart. For a null ray, p·dq = −p_t dt, so that the action shifts with the time. The time of the kernel's
/// state in ingoing coordinates is −t_in.
inline void integrals_to_ingoing(const Hole& hole, double r, double pt, double& action, double& time) {
    const double shift = time_shift(hole, r);
    action -= pt * shift;
    time = -(time + shift);
}
inline void integrals_to_outgoing(const Hole& hole, double r, double pt, double& action, double& time) {
    const double shift = time_shift(hole, r);
    action += pt * shift;
    time = -time - shift;
}

}  // namespace kagero::charts

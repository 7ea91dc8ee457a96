/// The initial momentum of a ray, for a direction in coordinates or in an observer's rest frame.
///
/// The momentum follows from derivatives of H by automatic differentiation. H must be quadratic in p, as all compiled
/// Hamiltonians are. In a spacetime its second derivatives ∂²H/∂p_a∂p_b are the inverse metric g^{ab}. In a medium they
/// are the inverse mass matrix, which is the unit matrix for H = ½(|p|² − N²).
#pragma once

#include "kernels/abi.h"
#include "kernels/autodiff/dual.h"
#include "kernels/observers/charts.h"
#include "kernels/observers/rest_frame.h"
#include "kernels/equations/system.h"

#include <algorithm>
#include <cmath>

namespace kagero {

/// H and its derivatives with respect to (p_x, p_y, p_z, p_t) at one position and the momentum (0, 0, 0, p_t).
struct MomentumExpansion {
    double value;                    ///< H
    std::array<double, 4> gradient;  ///< ∂H/∂p_a
    Matrix<4> hessian;               ///< ∂²H/∂p_a∂p_b, which does not depend on p
};

/// Returns the expansion of H at the position q. `pt` is p_t. Because ∂H/∂p is linear in p, each column of second
/// derivatives is the difference of two gradients ∂H/∂p, at momenta that differ by 1 in one component.
template <class H>
MomentumExpansion expand_in_momentum(const double* parameters, const double (&q)[3], double pt) {
    using DualNumber = Dual<double, 4>;
    DualNumber dual_parameters[H::parameters.size() + 1];
    for (std::size_t i = 0; i < H::parameters.size(); ++i) dual_parameters[i] = DualNumber(parameters[i]);
    // Returns H at the momentum p.
    const auto energy_at = [&](const std::array<double, 4>& p) {
        const auto variable = [&p](int i) { return DualNumber::variable(p[i], i); };
        return H::energy(make_parameters<H>(dual_parameters),
                         Vec3<DualNumber>{DualNumber(q[0]), DualNumber(q[1]), DualNumber(q[2])},
                         Vec3<DualNumber>{variable(0), variable(1), variable(2)}, variable(3));
    };
    const DualNumber h = energy_at({0, 0, 0, pt});
    MomentumExpansion e{h.value, h.derivative, {}};
    for (int b = 0; b < 4; ++b) {
        std::array<double, 4> p{0, 0, 0, pt};
        p[b] += 1;
        const DualNumber shifted = energy_at(p);
        for (int a = 0; a < 4; ++a) e.hessian[a][b] = shifted.derivative[a] - h.derivative[a];
    }
    return e;
}

/// Returns aᵀ G⁻¹ a.
inline double inverse_product(const StartPosition& at, const double (&a)[3]) {
    double sum = 0;
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) sum += a[i] * at.inverse_block[i][k] * a[k];
    return sum;
}

/// Computes the part of the starts of rays that depends only on their position q. Let v0 be the velocity ∂H/∂p at the
/// momentum (0, 0, 0, p_t), and G the spatial block of ∂²H/∂p_a∂p_b.
template <class H>
StartPosition start_position(const double* parameters, const double (&q)[3]) {
    const double pt = H::spacetime ? 1.0 : 0.0;
    StartPosition at{{q[0], q[1], q[2]}, pt, {}, {}, 0, Failure::singular_start};
    const MomentumExpansion e = expand_in_momentum<H>(parameters, q, pt);
    Matrix<3> spatial_block{};  // G; in a spacetime it is the spatial block of the inverse metric
    bool finite = std::isfinite(e.value);
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) {
            spatial_block[i][k] = e.hessian[i][k];
            finite = finite && std::isfinite(spatial_block[i][k]);
        }
    if (!finite) return at;
    const Matrix<3> inverse_block = inverse<3>(spatial_block);
    for (int i = 0; i < 3; ++i) {
        at.velocity[i] = e.gradient[i];
        std::copy(inverse_block[i].begin(), inverse_block[i].end(), at.inverse_block[i]);
    }
    at.scaled_square = 2 * (H::level - e.value + 0.5 * inverse_product(at, at.velocity));
    at.failure = Failure::none;
    return at;
}

/// Computes the start of a ray at q with the velocity ∂H/∂p = μ d/|d|, where d is a direction in coordinates, and μ > 0
/// is chosen so that H = H0: p = G⁻¹(μ d/|d| − v0).
inline Failure start_from(const StartPosition& at, const double (&d)[3], RayStart& out) {
    out = {{at.q[0], at.q[1], at.q[2]}, {0, 0, 0}, at.pt, Failure::none, false, false};
    const double length = std::hypot(d[0], d[1], d[2]);
    for (int i = 0; i < 3; ++i)
        if (!std::isfinite(at.q[i]) || !std::isfinite(d[i])) return out.failure = Failure::nonfinite_start;
    if (!(length > 0)) return out.failure = Failure::zero_direction;
    if (at.failure != Failure::none) return out.failure = at.failure;
    const double unit[3] = {d[0] / length, d[1] / length, d[2] / length};
    const double mu_squared = at.scaled_square / inverse_product(at, unit);
    if (!(mu_squared > 0) || !std::isfinite(mu_squared)) return out.failure = Failure::no_momentum;
    const double mu = std::sqrt(mu_squared);
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) out.p[i] += at.inverse_block[i][k] * (mu * unit[k] - at.velocity[k]);
    return Failure::none;
}

/// Computes the start of a ray at q with dq/dλ along d and H = H0.
template <class H>
Failure start_along(const double* parameters, const double (&q)[3], const double (&d)[3], RayStart& out) {
    return start_from(start_position<H>(parameters, q), d, out);
}

/// Returns the gradient ∂r/∂q of the radial coordinate r (Boyer–Lindquist or Schwarzschild) at the position q near a
/// black hole, and sets `radius` to r.
template <class H>
std::array<double, 3> radius_gradient(const double* parameters, const double (&q)[3], double& radius) {
    using DualNumber = Dual<double, 3>;
    DualNumber dual_parameters[H::parameters.size() + 1];
    for (std::size_t i = 0; i < H::parameters.size(); ++i) dual_parameters[i] = DualNumber(parameters[i]);
    const auto variable = [&](int i) { return DualNumber::variable(q[i], i); };
    const Vec3<DualNumber> position{variable(0), variable(1), variable(2)};
    const DualNumber r = H::radius(make_parameters<H>(dual_parameters), position);
    radius = r.value;
    return r.derivative;
}

/// True if H declares `infall(k, r)`, from which the 4-velocity of matter that falls from rest at infinity follows:
/// u_r = −infall(k, r) (see schwarzschild.h).
template <class H>
concept HasInfall = requires(const typename H::template Parameters<double>& k) { H::infall(k, 1.0); };

/// Returns the black hole at the origin of H.
template <HasInfall H>
Hole hole_of(const double* parameters) {
    return H::hole(make_parameters<H>(parameters));
}

/// Returns the covariant 4-velocity u_a = (u_x, u_y, u_z, u_t) of an observer, up to a factor. The observer is one of:
///   static      u_a = g_{at}, so that u^a points along ∂_t; `metric` is g_{ab}
///   coordinate  u_a = −∂t/∂x^a, where t is the time coordinate of H
///   zamo        u_a = −∂t'/∂x^a, where t' is the Boyer–Lindquist or Schwarzschild time; without a black hole, t' = t
///   falling     the 4-velocity of matter that falls from rest at infinity
template <class H>
std::array<double, 4> covariant_velocity(ObserverKind kind, const double* parameters, const double (&q)[3],
                                         const Matrix<4>& metric) {
    if (kind == ObserverKind::static_) return {metric[0][3], metric[1][3], metric[2][3], metric[3][3]};
    if constexpr (HasInfall<H>) {
        double r;
        const std::array<double, 3> dr = radius_gradient<H>(parameters, q, r);
        const auto hole_parameters = make_parameters<H>(parameters);
        const double minus_u_r = kind == ObserverKind::zamo      ? H::time_offset_gradient(hole_parameters, r)
                                 : kind == ObserverKind::falling ? H::infall(hole_parameters, r)
                                                                 : 0.0;
        return {-minus_u_r * dr[0], -minus_u_r * dr[1], -minus_u_r * dr[2], -1};
    } else {
        return {0, 0, 0, -1};
    }
}

/// Computes the map p = N(q) d from unit directions d to momenta, for an observer at rest in an isotropic medium with
/// the index of refraction N(q).
template <class H>
Failure compute_start_map_in_medium(const double* parameters, const double (&q)[3], StartMap& map) {
    RayStart start;
    if (const Failure f = start_along<H>(parameters, q, {1, 0, 0}, start); f != Failure::none) return f;
    const double index = std::sqrt(start.p[0] * start.p[0] + start.p[1] * start.p[1] + start.p[2] * start.p[2]);
    for (int i = 0; i < 3; ++i) map.matrix[i][i] = index;
    return Failure::none;
}

/// Computes the map for an observer that is not falling, in the coordinates of H. Near a black hole, these are the
/// outgoing coordinates.
template <class H>
Failure compute_map_in_coordinates_of(ObserverKind kind, const double* parameters, const double (&q)[3],
                                      StartMap& map) {
    const Matrix<4> inverse_metric = expand_in_momentum<H>(parameters, q, 1).hessian;
    Matrix<4> g;
    if (!metric_of(inverse_metric, g)) return Failure::singular_start;
    map.pt = kind == ObserverKind::static_ || kind == ObserverKind::zamo ? 1 : 0;
    return compute_rest_frame_map(inverse_metric, g, covariant_velocity<H>(kind, parameters, q, g), map);
}

/// Computes the map for a falling observer at the ingoing position q, in ingoing coordinates. Their metric is that of H
/// at the reflected position, with the signs of charts.h.
template <HasInfall H>
Failure compute_falling_map(const double* parameters, const double (&q)[3], StartMap& map) {
    charts::State state{{q[0], q[1], q[2]}, {1, 1, 1}, {}, 1};
    charts::reflect(hole_of<H>(parameters), state);
    const double sign[4] = {state.p[0], state.p[1], state.p[2], state.pt};
    Matrix<4> inverse_metric = expand_in_momentum<H>(parameters, state.q, 1).hessian, g;
    for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b) inverse_metric[a][b] *= sign[a] * sign[b];
    if (!metric_of(inverse_metric, g)) return Failure::singular_start;
    const auto u = covariant_velocity<H>(ObserverKind::falling, parameters, q, g);
    return compute_rest_frame_map(inverse_metric, g, u, map);
}

/// Calls function(state) for each column of the map: the momentum, at the position q, to which the map takes one axis
/// of the rest frame, and the offset. Replaces the column by the momentum in the state, and the map's position by the
/// state's position.
template <class Function>
void convert_columns(StartMap& map, const double (&q)[3], const Function& function) {
    for (int j = 0; j < 4; ++j) {
        const auto entry = [&](int i) -> double& { return j < 3 ? map.matrix[i][j] : map.offset[i]; };
        charts::State state{{q[0], q[1], q[2]}, {entry(0), entry(1), entry(2)}, {}, entry(3)};
        function(state);
        for (int i = 0; i < 3; ++i) {
            entry(i) = state.p[i];
            map.position[i] = state.q[i];
        }
        entry(3) = state.pt;
    }
}

/// Turns the axes of the rest frame by an angle about the z axis: directions d are replaced by the rotated directions.
inline void turn_axes(StartMap& map, double angle) {
    for (auto& row : map.matrix) charts::rotate(row, -angle);
}

/// Computes the map for an observer at the scene's position q near a black hole. The map is in outgoing coordinates, or
/// in ingoing coordinates if `ingoing` is true or q is inside the horizon. The falling observer's axes are those of the
/// ingoing coordinates, turned about the z axis by the difference between the azimuths of q in the two charts. On the
/// z axis, where there is no azimuth, they are not turned.
template <HasInfall H>
Failure compute_start_map_near_hole(ObserverKind kind, const double* parameters, const double (&q)[3], bool ingoing,
                                    StartMap& map) {
    const Hole hole = hole_of<H>(parameters);
    const bool inside = charts::is_inside(hole, q), falling = kind == ObserverKind::falling;
    // Inside the inner horizon, a vector along ∂_t may be timelike again. Observers there are refused nevertheless,
    // because light from there cannot reach the outside.
    if (inside && (kind == ObserverKind::static_ || kind == ObserverKind::zamo)) return Failure::no_observer;
    if (!falling) {
        const Failure failure = compute_map_in_coordinates_of<H>(kind, parameters, q, map);
        if (failure != Failure::none || !ingoing || inside) return failure;
        convert_columns(map, q, [&](charts::State& state) { charts::to_ingoing(hole, state); });
        map.pt = -map.pt;
        map.ingoing = true;
        return Failure::none;
    }
    const double angle = inside ? 0 : charts::azimuth_shift(hole, charts::radius(hole, q));
    double ingoing_q[3] = {q[0], q[1], q[2]};
    charts::rotate(ingoing_q, -angle);
    if (const Failure failure = compute_falling_map<H>(parameters, ingoing_q, map); failure != Failure::none)
        return failure;
    if (q[0] != 0 || q[1] != 0) turn_axes(map, -angle);
    map.ingoing = ingoing || inside;
    convert_columns(map, ingoing_q, [&](charts::State& state) {
        map.ingoing ? charts::reflect(hole, state) : charts::convert(hole, state, 1);
    });
    return Failure::none;
}

/// Computes the map from directions in the rest frame of an observer at q to momenta. Near a black hole, `ingoing`
/// selects the chart (compute_start_map_near_hole).
template <class H>
Failure compute_start_map(ObserverKind kind, const double* parameters, const double (&q)[3], bool ingoing,
                          StartMap& map) {
    map = {};
    std::copy(q, q + 3, map.position);
    const bool needs_spacetime = kind == ObserverKind::falling || kind == ObserverKind::zamo;
    if (needs_spacetime && (!H::spacetime || (kind == ObserverKind::falling && !HasInfall<H>)))
        return Failure::no_observer;
    if constexpr (!H::spacetime) return compute_start_map_in_medium<H>(parameters, q, map);
    else if constexpr (HasInfall<H>) return compute_start_map_near_hole<H>(kind, parameters, q, ingoing, map);
    else return compute_map_in_coordinates_of<H>(kind, parameters, q, map);
}

/// Returns the frequency p · u of a ray in the rest frame of matter at q that moves with the velocity v = dx/dt; 1 in a
/// medium.
template <class H>
double frequency_at(const double* parameters, const double (&q)[3], const double (&p)[3], double pt,
                    const double (&v)[3]) {
    if constexpr (!H::spacetime) return 1;
    return frequency_in(expand_in_momentum<H>(parameters, q, 0).hessian, p, pt, v);
}

}  // namespace kagero

/// The momentum a ray starts with: from a direction in coordinates, or from one in an observer's rest frame.
///
/// Everything follows from H by automatic differentiation: G^{ab} = ∂²H/∂p_a∂p_b is the inverse metric of a spacetime,
/// and the inverse "mass" of an index medium. H is quadratic in p for every Hamiltonian served here.
#pragma once

#include "kernels/abi.h"
#include "kernels/autodiff/dual.h"
#include "kernels/observers/rest_frame.h"
#include "kernels/equations/system.h"

#include <algorithm>
#include <cmath>

namespace kagero {

/// H − H0 at some (p_x, p_y, p_z, p_t), with first and second derivatives by them.
struct MomentumExpansion {
    double value;
    std::array<double, 4> gradient;
    Matrix<4> hessian;
};

/// At (0, 0, 0, p_t). The gradient is linear in p, so the second derivatives are what it grows by from there along each
/// axis.
template <class H>
MomentumExpansion expand_in_momentum(const double* parameters, const double (&q)[3], double pt) {
    using First = Dual<double, 4>;
    First k[H::parameters.size() + 1];
    for (std::size_t i = 0; i < H::parameters.size(); ++i) k[i] = First(parameters[i]);
    const auto at = [&](const std::array<double, 4>& p) {
        const auto variable = [&p](int i) { return First::variable(p[i], i); };
        return H::energy(make_parameters<H>(k), Vec3<First>{First(q[0]), First(q[1]), First(q[2])},
                         Vec3<First>{variable(0), variable(1), variable(2)}, variable(3));
    };
    const First h = at({0, 0, 0, pt});
    MomentumExpansion e{h.value, h.derivative, {}};
    for (int b = 0; b < 4; ++b) {
        std::array<double, 4> p{0, 0, 0, pt};
        p[b] += 1;
        const First there = at(p);
        for (int a = 0; a < 4; ++a) e.hessian[a][b] = there.derivative[a] - h.derivative[a];
    }
    return e;
}

/// p with ∂H/∂p along d in the same sense, and H = H0. With H quadratic in p, ∂H/∂p = μ d gives p = G⁻¹(μ d − v0), and
/// H = H0 fixes μ.
template <class H>
Failure start_along(const double* parameters, const double (&q)[3], const double (&d)[3], RayStart& out) {
    const double pt = H::spacetime ? 1.0 : 0.0;
    out = {{q[0], q[1], q[2]}, {0, 0, 0}, pt, Failure::none, false, false};
    const double length = std::hypot(d[0], d[1], d[2]);
    for (int i = 0; i < 3; ++i)
        if (!std::isfinite(q[i]) || !std::isfinite(d[i])) return out.failure = Failure::nonfinite_start;
    if (!(length > 0)) return out.failure = Failure::zero_direction;
    const MomentumExpansion e = expand_in_momentum<H>(parameters, q, pt);
    Matrix<3> g{};
    bool finite = std::isfinite(e.value);
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) g[i][k] = e.hessian[i][k], finite = finite && std::isfinite(g[i][k]);
    if (!finite) return out.failure = Failure::singular_start;
    const Matrix<3> gi = inverse<3>(g);
    const auto form = [&](const auto& a, const auto& b) {
        double sum = 0;
        for (int i = 0; i < 3; ++i)
            for (int k = 0; k < 3; ++k) sum += a[i] * gi[i][k] * b[k];
        return sum;
    };
    const double unit[3] = {d[0] / length, d[1] / length, d[2] / length};
    const double* v0 = e.gradient.data();
    const double square = 2 * (H::level - e.value + 0.5 * form(v0, v0)) / form(unit, unit);
    if (!(square > 0) || !std::isfinite(square)) return out.failure = Failure::no_momentum;
    const double mu = std::sqrt(square);
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) out.p[i] += gi[i][k] * (mu * unit[k] - v0[k]);
    return Failure::none;
}

/// The gradient of the radius that a hole's observers are described with.
template <class H>
std::array<double, 3> radius_gradient(const double* parameters, const double (&q)[3], double& radius) {
    using First = Dual<double, 3>;
    First k[H::parameters.size() + 1];
    for (std::size_t i = 0; i < H::parameters.size(); ++i) k[i] = First(parameters[i]);
    const auto at = [&](int i) { return First::variable(q[i], i); };
    const First r = H::radius(make_parameters<H>(k), Vec3<First>{at(0), at(1), at(2)});
    radius = r.value;
    return r.derivative;
}

template <class H>
concept Infalling = requires(const typename H::template Parameters<double>& k) { H::infall(k, 1.0); };

/// Whether a place is within the outer horizon, r₊ = M + √(M² − a²), where nobody rests for good.
template <Infalling H>
bool within_horizon(const double* parameters, const double (&q)[3]) {
    const auto k = make_parameters<H>(parameters);
    const Hole hole = H::hole(k);
    return H::radius(k, Vec3<double>{q[0], q[1], q[2]}) <=
           hole.mass + std::sqrt(std::max(hole.mass * hole.mass - hole.spin * hole.spin, 0.0));
}

/// A covector along the observer's lowered 4-velocity, (u_x, u_y, u_z, u_t) of any length: −dt of the coordinates, −dt
/// of Boyer and Lindquist, or that of rain. The static observer's has u^a along ∂_t.
template <class H>
std::array<double, 4> lowered_velocity(ObserverKind kind, const double* parameters, const double (&q)[3],
                                       const Matrix<4>& metric) {
    if (kind == ObserverKind::static_) return {metric[0][3], metric[1][3], metric[2][3], metric[3][3]};
    if constexpr (Infalling<H>) {
        double r;
        const std::array<double, 3> slope = radius_gradient<H>(parameters, q, r);
        const auto k = make_parameters<H>(parameters);
        const double s = kind == ObserverKind::zamo      ? H::time_offset_gradient(k, r)
                         : kind == ObserverKind::falling ? H::infall(k, r)
                                                         : 0.0;
        return {-s * slope[0], -s * slope[1], -s * slope[2], -1};
    } else {
        return {0, 0, 0, -1};
    }
}

/// p = N(q) d for directions d, the same for every observer at rest in an isotropic medium.
template <class H>
Failure observe_medium(const double* parameters, const double (&q)[3], StartMap& map) {
    RayStart x;
    if (const Failure f = start_along<H>(parameters, q, {1, 0, 0}, x); f != Failure::none) return f;
    const double size = std::sqrt(x.p[0] * x.p[0] + x.p[1] * x.p[1] + x.p[2] * x.p[2]);
    for (int i = 0; i < 3; ++i) map.matrix[i][i] = size;
    return Failure::none;
}

/// Directions of an observer's rest frame to momenta. A falling observer lives in the ingoing form of the metric, the
/// outgoing one with t → −t: there a hole of the parameters given spins the other way.
template <class H>
Failure observe(ObserverKind kind, const double* parameters, const double (&q)[3], StartMap& map) {
    map = {};
    const bool needs_hole = kind == ObserverKind::falling || kind == ObserverKind::zamo;
    if (needs_hole && (!H::spacetime || (kind == ObserverKind::falling && !Infalling<H>))) return Failure::no_observer;
    if constexpr (!H::spacetime) return observe_medium<H>(parameters, q, map);
    // Within an inner horizon r is a length again, and rest is timelike: but nothing comes out of there.
    if constexpr (Infalling<H>)
        if ((kind == ObserverKind::static_ || kind == ObserverKind::zamo) && within_horizon<H>(parameters, q))
            return Failure::no_observer;
    Matrix<4> inverse_metric = expand_in_momentum<H>(parameters, q, 1).hessian, g;
    const double time = kind == ObserverKind::falling ? -1 : 1;
    for (int i = 0; i < 3; ++i) inverse_metric[i][3] *= time, inverse_metric[3][i] *= time;
    if (!metric_of(inverse_metric, g)) return Failure::singular_start;
    map.pt = kind == ObserverKind::static_ || kind == ObserverKind::zamo ? 1 : 0;
    return rest_frame(inverse_metric, g, lowered_velocity<H>(kind, parameters, q, g), time, map);
}

/// p · u for matter that moves with the velocity v = dx/dt (rest_frame.h).
template <class H>
double frequency_at(const double* parameters, const double (&q)[3], const double (&p)[3], double pt,
                    const double (&v)[3], double time) {
    if constexpr (!H::spacetime) return 1;
    return frequency_in(expand_in_momentum<H>(parameters, q, 0).hessian, p, pt, v, time);
}

}  // namespace kagero

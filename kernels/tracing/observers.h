/// The momentum a ray starts with: from a direction in coordinates, or from one in an observer's rest frame.
///
/// Everything follows from H by automatic differentiation: G^{ab} = ∂²H/∂p_a∂p_b is the inverse metric of a spacetime, and the
/// inverse "mass" of an index medium. H is quadratic in p for every Hamiltonian served here.
#pragma once

#include "kernels/abi.h"
#include "kernels/numeric/dual.h"
#include "kernels/stepping/system.h"

#include <cmath>

namespace kagero {

template <int n>
using Matrix = std::array<std::array<double, n>, n>;

/// Inverse by Gauss–Jordan elimination with row pivoting; not finite when singular.
template <int n>
Matrix<n> inverse(Matrix<n> m) {
    Matrix<n> r{};
    for (int i = 0; i < n; ++i) r[i][i] = 1;
    for (int c = 0; c < n; ++c) {
        int pivot = c;
        for (int i = c + 1; i < n; ++i)
            if (std::abs(m[i][c]) > std::abs(m[pivot][c])) pivot = i;
        std::swap(m[c], m[pivot]), std::swap(r[c], r[pivot]);
        const double scale = 1 / m[c][c];
        for (int k = 0; k < n; ++k) m[c][k] *= scale, r[c][k] *= scale;
        for (int i = 0; i < n; ++i) {
            if (i == c) continue;
            const double factor = m[i][c];
            for (int k = 0; k < n; ++k) m[i][k] -= factor * m[c][k], r[i][k] -= factor * r[c][k];
        }
    }
    return r;
}

/// h^(−1/2) of a symmetric positive definite matrix, by Denman and Beavers (1976).
inline Matrix<3> inverse_square_root(const Matrix<3>& h) {
    Matrix<3> y = h, z{};
    for (int i = 0; i < 3; ++i) z[i][i] = 1;
    for (int step = 0; step < 40; ++step) {
        const Matrix<3> yi = inverse<3>(y), zi = inverse<3>(z);
        for (int i = 0; i < 3; ++i)
            for (int k = 0; k < 3; ++k) y[i][k] = 0.5 * (y[i][k] + zi[i][k]), z[i][k] = 0.5 * (z[i][k] + yi[i][k]);
    }
    return z;
}

/// H at p = 0 and unit-free p_t, with first and second derivatives by (p_x, p_y, p_z, p_t).
struct MomentumExpansion {
    double value;
    std::array<double, 4> gradient;
    Matrix<4> hessian;
};

template <class H>
MomentumExpansion expand_in_momentum(const double* parameters, const double (&q)[3], double pt) {
    using First = Dual<double, 4>;
    using Second = Dual<First, 4>;
    Second k[H::parameters.size() + 1];
    for (std::size_t i = 0; i < H::parameters.size(); ++i) k[i] = Second(parameters[i]);
    const auto variable = [](double x, int i) { return Second::variable(First::variable(x, i), i); };
    const Vec3<Second> position{Second(q[0]), Second(q[1]), Second(q[2])};
    const Second h = H::energy(make_parameters<H>(k), position, Vec3<Second>{variable(0, 0), variable(0, 1), variable(0, 2)},
                               variable(pt, 3));
    MomentumExpansion e{h.value.value, h.value.derivative, {}};
    for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b) e.hessian[a][b] = h.derivative[a].derivative[b];
    return e;
}

/// p with ∂H/∂p along d in the same sense, and H = H0. With H quadratic in p, ∂H/∂p = μ d gives p = G⁻¹(μ d − v0), and H = H0 fixes μ.
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
concept Hole = requires(const typename H::template Parameters<double>& k) { H::infall(k, 1.0); };

/// A covector along the observer's lowered 4-velocity, (u_x, u_y, u_z, u_t) of any length: −dt of the coordinates, −dt of Boyer and
/// Lindquist, or that of rain. The static observer's has u^a along ∂_t.
template <class H>
std::array<double, 4> lowered_velocity(ObserverKind kind, const double* parameters, const double (&q)[3], const Matrix<4>& metric) {
    if (kind == ObserverKind::static_) return {metric[0][3], metric[1][3], metric[2][3], metric[3][3]};
    if constexpr (Hole<H>) {
        double r;
        const std::array<double, 3> slope = radius_gradient<H>(parameters, q, r);
        const auto k = make_parameters<H>(parameters);
        const double s = kind == ObserverKind::zamo ? H::lag(k, r) : kind == ObserverKind::falling ? H::infall(k, r) : 0.0;
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

/// Directions of an observer's rest frame to momenta. The frame's axes are the coordinate axes projected orthogonally to the
/// 4-velocity u and orthonormalised symmetrically, E = h^(−1/2) e; the ray, followed backward from the eye, is p = −u + d·E. A falling
/// observer lives in the ingoing form of the metric: its time is −t, and so is its p_t.
template <class H>
Failure observe(ObserverKind kind, const double* parameters, const double (&q)[3], StartMap& map) {
    map = {};
    const bool needs_hole = kind == ObserverKind::falling || kind == ObserverKind::zamo;
    if (needs_hole && (!H::spacetime || (kind == ObserverKind::falling && !Hole<H>))) return Failure::no_observer;
    if constexpr (!H::spacetime) return observe_medium<H>(parameters, q, map);
    const MomentumExpansion e = expand_in_momentum<H>(parameters, q, 1);
    Matrix<4> inverse_metric = e.hessian;
    const double time = kind == ObserverKind::falling ? -1 : 1;
    for (int i = 0; i < 3; ++i) inverse_metric[i][3] *= time, inverse_metric[3][i] *= time;
    const Matrix<4> g = inverse<4>(inverse_metric);
    for (const auto& row : g)
        for (const double x : row)
            if (!std::isfinite(x)) return Failure::singular_start;
    std::array<double, 4> u = lowered_velocity<H>(kind, parameters, q, g), up{};
    double square = 0, terms = 0;
    for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b) up[a] += inverse_metric[a][b] * u[b];
    for (int a = 0; a < 4; ++a) square += u[a] * up[a], terms += std::abs(u[a] * up[a]);
    // On a horizon nothing is left of u² but rounding.
    if (!(square < -64 * machine_epsilon<double> * terms) || !std::isfinite(square)) return Failure::no_observer;
    // u^t > 0: into the future.
    const double scale = (up[3] > 0 ? 1 : -1) / std::sqrt(-square);
    for (int a = 0; a < 4; ++a) u[a] *= scale, up[a] *= scale;
    Matrix<3> h{};  // e_i · e_k with e_i^a = δ_i^a + u^a u_i
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) h[i][k] = g[i][k] + u[i] * u[k];
    const Matrix<3> root = inverse_square_root(h);
    for (int a = 0; a < 4; ++a) {
        const double sign = a == 3 ? time : 1;
        map.offset[a] = -sign * u[a];
        for (int i = 0; i < 3; ++i)
            for (int k = 0; k < 3; ++k) map.matrix[a][i] += sign * root[i][k] * (g[k][a] + u[k] * u[a]);
    }
    map.unit_pt = kind == ObserverKind::static_ || kind == ObserverKind::zamo;
    return Failure::none;
}

}  // namespace kagero

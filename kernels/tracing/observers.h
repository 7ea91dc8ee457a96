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
    out = {{q[0], q[1], q[2]}, {0, 0, 0}, pt, Failure::none};
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

/// Directions of a static observer's rest frame to momenta. The frame's axes are the coordinate axes projected orthogonally to the
/// 4-velocity u and orthonormalised symmetrically, E = h^(−1/2) e; the ray, followed backward from the eye, is p = −u + d·E.
template <class H>
Failure observe_static(const double* parameters, const double (&q)[3], StartMap& map) {
    map = {};
    if constexpr (!H::spacetime) {
        RayStart x;
        if (const Failure f = start_along<H>(parameters, q, {1, 0, 0}, x); f != Failure::none) return f;
        const double size = std::sqrt(x.p[0] * x.p[0] + x.p[1] * x.p[1] + x.p[2] * x.p[2]);
        for (int i = 0; i < 3; ++i) map.matrix[i][i] = size;
        return Failure::none;
    }
    const MomentumExpansion e = expand_in_momentum<H>(parameters, q, 1);
    if (!std::isfinite(e.value) || !std::isfinite(e.hessian[0][0])) return Failure::singular_start;
    const Matrix<4> g = inverse<4>(e.hessian);
    if (!(g[3][3] < 0)) return Failure::no_momentum;
    std::array<double, 4> lower_u{};  // u^a = (0, 0, 0, 1/√−g_tt)
    const double ut = 1 / std::sqrt(-g[3][3]);
    for (int a = 0; a < 4; ++a) lower_u[a] = g[a][3] * ut;
    Matrix<3> h{};  // e_i · e_k with e_i^a = δ_i^a + u^a u_i
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) h[i][k] = g[i][k] + lower_u[i] * lower_u[k];
    const Matrix<3> root = inverse_square_root(h);
    for (int a = 0; a < 4; ++a) {
        map.offset[a] = -lower_u[a];
        for (int i = 0; i < 3; ++i)
            for (int k = 0; k < 3; ++k) map.matrix[a][i] += root[i][k] * (g[k][a] + lower_u[k] * lower_u[a]);
    }
    map.unit_pt = true;
    return Failure::none;
}

}  // namespace kagero

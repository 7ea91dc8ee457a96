/// The rest frame of an observer from the inverse metric G^{ab} = ∂²H/∂p_a∂p_b where it stands; indices are x, y, z, t.
#pragma once

#include "kernels/abi.h"

#include <array>
#include <cmath>
#include <limits>
#include <utility>

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

/// Directions of the rest frame of an observer with the lowered 4-velocity u_a, of any length, to momenta. The frame's
/// axes are the coordinate axes projected orthogonally to u and orthonormalised symmetrically, E = h^(−1/2) e; the ray,
/// followed backward from the eye, is p = −u + d·E. With `time` −1 the observer lives in the metric with t → −t, which
/// is the one given: its time is −t, and so is its p_t.
inline Failure rest_frame(const Matrix<4>& inverse_metric, const Matrix<4>& g, std::array<double, 4> u, double time,
                          StartMap& map) {
    std::array<double, 4> up{};
    double square = 0, terms = 0;
    for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b) up[a] += inverse_metric[a][b] * u[b];
    for (int a = 0; a < 4; ++a) square += u[a] * up[a], terms += std::abs(u[a] * up[a]);
    // On a horizon nothing is left of u² but rounding.
    if (!(square < -64 * std::numeric_limits<double>::epsilon() * terms) || !std::isfinite(square))
        return Failure::no_observer;
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
    return Failure::none;
}

/// The inverse of an inverse metric; false when it is none.
inline bool metric_of(const Matrix<4>& inverse_metric, Matrix<4>& g) {
    g = inverse<4>(inverse_metric);
    for (const auto& row : g)
        for (const double x : row)
            if (!std::isfinite(x)) return false;
    return true;
}

/// p · u for matter with u = u^t (v, 1). The ray is followed from the eye, so p belongs to light that runs backward in
/// time, and the frequency is p · u = −k · u with the momentum k = −p of the light itself. With `time` −1 the metric is
/// the one with t → −t, where the matter's velocity is −v. Not a number where v is no velocity of matter.
inline double frequency_in(const Matrix<4>& inverse_metric, const double (&p)[3], double pt, const double (&v)[3],
                           double time) {
    const Matrix<4> g = inverse<4>(inverse_metric);
    const double w[4] = {time * v[0], time * v[1], time * v[2], 1};
    double square = 0;
    for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b) square += w[a] * g[a][b] * w[b];
    if (!(square < 0)) return std::numeric_limits<double>::quiet_NaN();
    return time * (w[0] * p[0] + w[1] * p[1] + w[2] * p[2] + pt) / std::sqrt(-square);
}

}  // namespace kagero

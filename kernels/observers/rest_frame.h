/// The rest frame of an observer, computed from the metric at its position. `inverse_metric` is g^{ab} = ∂²H/∂p_a∂p_b,
/// and `g` is g_{ab}. The indices 0, 1, 2, 3 belong to x, y, z, t.
#pragma once

#include "kernels/abi.h"

#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace kagero {

template <int n>
using Matrix = std::array<std::array<double, n>, n>;

/// Returns the inverse of a matrix by Gauss–Jordan elimination with partial pivoting. The result is not finite if the
/// matrix is singular.
template <int n>
Matrix<n> inverse(Matrix<n> m) {
    Matrix<n> r{};
    for (int i = 0; i < n; ++i) r[i][i] = 1;
    for (int c = 0; c < n; ++c) {
        int pivot = c;
        for (int i = c + 1; i < n; ++i)
            if (std::abs(m[i][c]) > std::abs(m[pivot][c])) pivot = i;
        std::swap(m[c], m[pivot]);
        std::swap(r[c], r[pivot]);
        const double scale = 1 / m[c][c];
        for (int k = 0; k < n; ++k) {
            m[c][k] *= scale;
            r[c][k] *= scale;
        }
        for (int i = 0; i < n; ++i) {
            if (i == c) continue;
            const double factor = m[i][c];
            for (int k = 0; k < n; ++k) {
                m[i][k] -= factor * m[c][k];
                r[i][k] -= factor * r[c][k];
            }
        }
    }
    return r;
}

/// Returns h^(−1/2) of a symmetric positive definite matrix, by the iteration of Denman and Beavers (1976).
inline Matrix<3> inverse_square_root(const Matrix<3>& h) {
    Matrix<3> y = h, z{};
    for (int i = 0; i < 3; ++i) z[i][i] = 1;
    for (int step = 0; step < 40; ++step) {
        const Matrix<3> yi = inverse<3>(y), zi = inverse<3>(z);
        for (int i = 0; i < 3; ++i)
            for (int k = 0; k < 3; ++k) {
                y[i][k] = 0.5 * (y[i][k] + zi[i][k]);
                z[i][k] = 0.5 * (z[i][k] + yi[i][k]);
            }
    }
    return z;
}

/// Computes the map from directions d in the rest frame of an observer to momenta. `u` is the covariant 4-velocity of
/// the observer, up to a factor. Let e_i be the coordinate axes, projected orthogonally to u, and h_ik = e_i · e_k. The
/// axes of the frame are E_i = Σ_k (h^(−1/2))_ik e_k (symmetric orthonormalization). Rays are followed backward from
/// the eye: p = −u + Σ_i d_i E_i.
inline Failure compute_rest_frame_map(const Matrix<4>& inverse_metric, const Matrix<4>& g, std::array<double, 4> u,
                                      StartMap& map) {
    std::array<double, 4> contravariant_u{};
    double u_squared = 0, sum_of_magnitudes = 0;
    for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b) contravariant_u[a] += inverse_metric[a][b] * u[b];
    for (int a = 0; a < 4; ++a) {
        u_squared += u[a] * contravariant_u[a];
        sum_of_magnitudes += std::abs(u[a] * contravariant_u[a]);
    }
    // u² must be negative; on a horizon it may be zero up to rounding.
    if (!(u_squared < -64 * std::numeric_limits<double>::epsilon() * sum_of_magnitudes) || !std::isfinite(u_squared))
        return Failure::no_observer;
    // The 4-velocity points to the future: u^t > 0.
    const double scale = (contravariant_u[3] > 0 ? 1 : -1) / std::sqrt(-u_squared);
    for (int a = 0; a < 4; ++a) {
        u[a] *= scale;
        contravariant_u[a] *= scale;
    }
    Matrix<3> h{};  // e_i · e_k with e_i^a = δ_i^a + u^a u_i
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) h[i][k] = g[i][k] + u[i] * u[k];
    const Matrix<3> inverse_root = inverse_square_root(h);
    for (int a = 0; a < 4; ++a) {
        map.offset[a] = -u[a];
        for (int i = 0; i < 3; ++i)
            for (int k = 0; k < 3; ++k) map.matrix[a][i] += inverse_root[i][k] * (g[k][a] + u[k] * u[a]);
    }
    return Failure::none;
}

/// Sets g to the inverse of an inverse metric. Returns false if the inverse metric is singular.
inline bool metric_of(const Matrix<4>& inverse_metric, Matrix<4>& g) {
    g = inverse<4>(inverse_metric);
    for (const auto& row : g)
        for (const double x : row)
            if (!std::isfinite(x)) return false;
    return true;
}

/// Returns the frequency p · u of a ray in the rest frame of matter with the 4-velocity u = u^t (v, 1). Rays are
/// followed backward from the eye. The momentum of the light is therefore k = −p, and its frequency is −k · u = p · u.
/// Returns NaN if |v| is not below the speed of light.
inline double frequency_in(const Matrix<4>& inverse_metric, const double (&p)[3], double pt, const double (&v)[3]) {
    const Matrix<4> g = inverse<4>(inverse_metric);
    const double w[4] = {v[0], v[1], v[2], 1};
    double square = 0;
    for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b) square += w[a] * g[a][b] * w[b];
    if (!(square < 0)) return std::numeric_limits<double>::quiet_NaN();
    return (w[0] * p[0] + w[1] * p[1] + w[2] * p[2] + pt) / std::sqrt(-square);
}

}  // namespace kagero

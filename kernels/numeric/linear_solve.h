/// Solver for small dense systems of linear equations, for one ray.
#pragma once

#include <cmath>
#include <utility>

namespace kagero {

using std::abs;

/// Solves A x = b with n rows by Gaussian elimination with partial pivoting. A is overwritten. b is replaced by x,
/// which is not finite if A is singular. Returns true if det A > 0.
template <class Row, class S>
bool solve_linear(int n, Row* a, S* b) {
    bool is_regular = true, determinant_is_positive = true;
    for (int k = 0; k < n; ++k) {
        int pivot = k;
        for (int i = k + 1; i < n; ++i)
            if (abs(a[i][k]) > abs(a[pivot][k])) pivot = i;
        if (pivot != k) {
            determinant_is_positive = !determinant_is_positive;
            for (int j = k; j < n; ++j) std::swap(a[k][j], a[pivot][j]);
            std::swap(b[k], b[pivot]);
        }
        is_regular = is_regular && abs(a[k][k]) > S(0);
        if (a[k][k] < S(0)) determinant_is_positive = !determinant_is_positive;
        const S inverse = S(1) / a[k][k];
        for (int i = k + 1; i < n; ++i) {
            const S factor = a[i][k] * inverse;
            for (int j = k + 1; j < n; ++j) a[i][j] -= factor * a[k][j];
            b[i] -= factor * b[k];
        }
    }
    for (int k = n; k-- > 0;) {
        for (int j = k + 1; j < n; ++j) b[k] -= a[k][j] * b[j];
        b[k] /= a[k][k];
    }
    return is_regular && determinant_is_positive;
}

}  // namespace kagero

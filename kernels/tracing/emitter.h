/// The frequency that moving matter gives to the light of a ray.
#pragma once

#include "kernels/tracing/observers.h"

#include <limits>

namespace kagero {

/// p · u for matter with u = u^t (v, 1). The ray is followed from the eye, so p belongs to light that runs backward in time, p_t > 0,
/// and the frequency is p · u = −k · u with the momentum k = −p of the light itself. A ray with p_t < 0 was started by an observer who
/// lives in the metric with t → −t, and there the matter's velocity is v.
template <class H>
double frequency_at(const double* parameters, const double (&q)[3], const double (&p)[3], double pt, const double (&v)[3]) {
    if constexpr (!H::spacetime) return 1;
    const Matrix<4> g = inverse<4>(expand_in_momentum<H>(parameters, q, pt).hessian);
    const double time = pt < 0 ? -1 : 1;
    const double w[4] = {time * v[0], time * v[1], time * v[2], 1};
    double square = 0;
    for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b) square += w[a] * g[a][b] * w[b];
    if (!(square < 0)) return std::numeric_limits<double>::quiet_NaN();
    return time * (w[0] * p[0] + w[1] * p[1] + w[2] * p[2] + pt) / std::sqrt(-square);
}

}  // namespace kagero

/// Rays around a Schwarzschild hole of r_g = 1 that come in with a given impact parameter.
#pragma once

#include "render/render.h"

#include <cmath>
#include <string>

namespace kagero::stability {

inline const double critical_impact = 1.5 * std::sqrt(3.0);

/// Two unit vectors that span an orbital plane.
struct OrbitPlane {
    Double3 outward, across;
};

/// Planes along the axes and askew.
inline const OrbitPlane planes[] = {
    {{1, 0, 0}, {0, 1, 0}},
    {{0, 0, -1}, {0, 1, 0}},
    {{0.6, 0, 0.8}, {-0.8, 0, 0.6}},
    {{2.0 / 3, 1.0 / 3, 2.0 / 3}, {1.0 / 3, 2.0 / 3, -2.0 / 3}},
};

/// The ray that starts at radius r in a plane, inward, with impact parameter b: with H = 0 and p_t = 1, dq/dλ is
/// −√(1 − (1 − 1/r) b²/r²) along the radius and b/r across it.
inline RayInput ray_inward(const OrbitPlane& plane, double b, double r) {
    const double along = -std::sqrt(1 - (1 - 1 / r) * b * b / (r * r)), aside = b / r;
    RayInput ray{};
    for (std::size_t k = 0; k < 3; ++k) {
        ray.position[k] = r * plane.outward[k];
        ray.direction[k] = along * plane.outward[k] + aside * plane.across[k];
    }
    return ray;
}

/// A hole of r_g = 1; `integrator` are further lines of that table.
std::string hole(const std::string& method, double step, const std::string& integrator = "");

}  // namespace kagero::stability

/// Rays with a given impact parameter around a Schwarzschild hole of r_g = 1.
#pragma once

#include "render/render.h"

#include <cmath>
#include <string>

namespace kagero::stability {

/// Impact parameter b_c = 3√3/2 r_g that separates captured from escaped rays.
inline const double critical_impact = 1.5 * std::sqrt(3.0);

/// Two orthogonal unit vectors that span an orbit plane.
struct OrbitPlane {
    Double3 outward, across;
};

/// Orbit planes in axis-parallel and oblique positions.
inline const OrbitPlane planes[] = {
    {{1, 0, 0}, {0, 1, 0}},
    {{0, 0, -1}, {0, 1, 0}},
    {{0.6, 0, 0.8}, {-0.8, 0, 0.6}},
    {{2.0 / 3, 1.0 / 3, 2.0 / 3}, {1.0 / 3, 2.0 / 3, -2.0 / 3}},
};

/// Returns an inward ray in `plane` with impact parameter b that starts at r · `outward`. For H = 0 and p_t = 1, dq/dλ
/// has the radial component −√(1 − (1 − 1/r) b²/r²) and the tangential component b/r.
inline RayInput ray_inward(const OrbitPlane& plane, double b, double r) {
    const double radial = -std::sqrt(1 - (1 - 1 / r) * b * b / (r * r)), tangential = b / r;
    RayInput ray{};
    for (std::size_t k = 0; k < 3; ++k) {
        ray.position[k] = r * plane.outward[k];
        ray.direction[k] = radial * plane.outward[k] + tangential * plane.across[k];
    }
    return ray;
}

/// Returns the scene text of a hole of r_g = 1. `integrator` contains further lines of the table [integrator].
std::string hole_scene_text(const std::string& method, double step, const std::string& integrator = "");

}  // namespace kagero::stability

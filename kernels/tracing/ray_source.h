/// Where rays come from: the pixels of a camera, or a list.
#pragma once

#include "kernels/abi.h"

#include <cmath>

namespace kagero {

/// Canonical state seen by an observer in direction d of its rest frame (any length).
inline RayStart start_from_map(const StartMap& map, const double (&q)[3], double dx, double dy, double dz) {
    const double inverse = 1 / std::sqrt(dx * dx + dy * dy + dz * dz);
    const double d[3] = {dx * inverse, dy * inverse, dz * inverse};
    double p[4];
    for (int i = 0; i < 4; ++i) p[i] = map.matrix[i][0] * d[0] + map.matrix[i][1] * d[1] + map.matrix[i][2] * d[2] + map.offset[i];
    // Inside an ergosphere light of p_t <= 0 cannot have come from outside: only a hole sends it.
    const bool captured = map.unit_pt && !(p[3] > 0);
    const double scale = map.unit_pt && !captured ? 1 / p[3] : 1;
    return {{q[0], q[1], q[2]}, {p[0] * scale, p[1] * scale, p[2] * scale}, p[3] * scale, Failure::none, captured};
}

/// The ray through the middle of pixel (x, y).
inline RayStart camera_ray(const CameraRays& c, std::uint32_t x, std::uint32_t y) {
    const double u = x + 0.5, v = y + 0.5;
    double d[3];
    for (int k = 0; k < 3; ++k) d[k] = c.corner[k] + u * c.right[k] + v * c.down[k];
    return start_from_map(c.start, c.position, d[0], d[1], d[2]);
}

}  // namespace kagero

/// Baseline for scenes with straight rays: a loop that only queries Embree.
#pragma once

#include "kernels/abi.h"

namespace kagero::bench {

/// Traces the camera rays of a tile as straight rays and writes their ends, row by row. A ray ends at the first surface
/// that it meets, or with the status `escaped` at the distance 2·escape_radius. Rays are traced in packets of 16 (4 × 4
/// pixels).
void bare_embree(const CameraRays& camera, const Geometry& geometry, double escape_radius, const Tile& tile,
                 RayEnd* ends);

}  // namespace kagero::bench

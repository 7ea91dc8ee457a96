/// Straight light by Embree alone: what kagero is measured against where nothing bends.
#pragma once

#include "kernels/abi.h"

namespace kagero::bench {

/// The first surface that the camera's straight rays through a tile meet; all that hit nothing have escaped. Sixteen
/// rays at a time, or as many as Embree takes at once on this instruction set.
void bare_embree(const CameraRays& camera, const Geometry& geometry, double escape_radius, const Tile& tile,
                 RayEnd* ends);

}  // namespace kagero::bench

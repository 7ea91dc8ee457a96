/// Searches of Embree for the triangles around a point.
#pragma once

#include "kernels/abi.h"
#include "scene/vector3.h"

#include <rtcore.h>

namespace kagero {

/// Returns a distance in Embree's coordinates, rounded up to single precision.
float search_radius(const Geometry& geometry, double distance);

/// Calls `visit` for the triangles whose bounding boxes in stretched space are within `distance` of the point q. q is
/// given in unstretched coordinates. In stretched space, coordinates are multiplied by `stretch`; `scene` is in it.
void query_around(const Geometry& geometry, RTCScene scene, const Double3& stretch, const Double3& q, double distance,
                  RTCPointQueryFunction visit, void* user);

}  // namespace kagero

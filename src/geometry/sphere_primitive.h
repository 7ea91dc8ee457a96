/// Spheres as user geometries of Embree. Embree finds the spheres whose bounding boxes a segment passes; the
/// intersection is computed in double precision.
#pragma once

#include "kernels/abi.h"

#include <array>

#include <rtcore.h>

namespace kagero {

/// A sphere with the map to Embree's coordinates, (q − shift)·scale.
struct SpherePrimitive {
    Surface surface;
    std::array<double, 3> shift;
    double scale;
};

/// Returns a geometry with one sphere. Embree keeps a pointer to `sphere`.
RTCGeometry sphere_geometry(RTCDevice device, SpherePrimitive& sphere);

}  // namespace kagero

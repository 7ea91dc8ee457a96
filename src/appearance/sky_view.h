/// Which sky an escaped ray sees, and where on it.
#pragma once

#include "modules/space.h"
#include "scene/vector3.h"

namespace kagero {

struct SkyView {
    bool far;           ///< the sky of a wormhole's other universe
    Double3 direction;  ///< unit
};

/// In isotropic coordinates a wormhole's other universe lies within a sphere |q| < R, turned inside out by the
/// inversion q → q R²/|q|². Its differential mirrors directions at the plane across n = q/|q|, so that there the
/// direction d of a ray is d − 2 (d·n) n of the other universe.
SkyView sky_view(const Space& space, const RayEnd& end);

/// The same with R, 0 where there is no other universe; q relative to `space.center`.
SkyView sky_view(double radius, const Double3& q, const Double3& d);

}  // namespace kagero

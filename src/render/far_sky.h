/// Which sky an escaped ray sees, and where on it.
#pragma once

#include "render/plan.h"

namespace kagero {

struct SkyView {
    bool far;           ///< the sky of a wormhole's other universe
    Double3 direction;  ///< unit
};

/// In isotropic coordinates a wormhole's other universe lies within |q| < throat/2, turned inside out by the inversion
/// q → q (throat/2)²/|q|². Its differential mirrors directions at the plane across n = q/|q|, so that there the direction d of a ray
/// is d − 2 (d·n) n of the other universe.
SkyView sky_view(const Plan& plan, const RayEnd& end);

/// The same for a space with `throat`, 0 where it has none; q relative to `space.center`.
SkyView sky_view(double throat, const Double3& q, const Double3& d);

}  // namespace kagero

/// Colours, and the parts of the sky and of surfaces that rays cover.
#pragma once

#include "scene/description.h"

namespace kagero {

/// Linear RGB colour.
using Float3 = std::array<float, 3>;

/// Small ellipse of directions on the sky that a ray or a pixel covers.
struct Footprint {
    Double3 major{}, minor{};  ///< The two axes, as perpendicular vectors. Their lengths are the diameters, in radians.
};

/// Parallelogram on a surface that a ray covers, in the unit of RayEnd::q. Its sides are the displacements of the ray's
/// end if the ray is moved on the picture by the mean distance between rays, to the right and down.
struct Patch {
    Double3 right{}, below{};
};

}  // namespace kagero

/// The sky to which a ray escapes, and the direction of the ray on that sky.
#pragma once

#include "modules/space.h"
#include "scene/vector3.h"

namespace kagero {

/// The sky to which a ray escapes, and the direction of the ray on that sky.
struct SkyView {
    bool on_second_sheet;  ///< True if the sky is that of a wormhole's second sheet ([sky.far]).
    Double3 direction;     ///< Unit vector.
};

/// Returns the sky and the direction of an escaped ray. In isotropic coordinates, the second sheet of a wormhole is the
/// inside of the sphere |q| = R. The inversion q → q R²/|q|² maps this inside to its outside, where the metric has the
/// same form as that of the first sheet. The differential of the inversion reflects directions at the plane
/// perpendicular to n = q/|q|. A ray of direction d inside the sphere therefore has the direction d − 2 (d·n) n on the
/// second sheet.
SkyView sky_view(const Space& space, const RayEnd& end);

/// Returns the sky and the direction of an escaped ray that ends at q, relative to `space.center`, with the unit
/// direction d. `throat_radius` is R, or 0 if there is no second sheet.
SkyView sky_view(double throat_radius, const Double3& q, const Double3& d);

}  // namespace kagero

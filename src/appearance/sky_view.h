/// The sky to which a ray escapes, and the direction of the ray on that sky.
#pragma once

#include "modules/space.h"
#include "scene/vector3.h"

namespace kagero {

/// The sky to which a ray escapes, and the direction of the ray on that sky.
struct SkyView {
    bool far;           ///< True for the sky of a wormhole's second sheet ([sky.far]).
    Double3 direction;  ///< Unit vector.
};

/// Returns the sky and the direction of an escaped ray. In isotropic coordinates, the second sheet of a wormhole is the
/// inside of the sphere |q| = R. The inversion q → q R²/|q|² maps it to coordinates of the same form as those of the
/// first sheet. The differential of the inversion reflects directions at the plane perpendicular to n = q/|q|. A ray of
/// direction d inside the sphere therefore has the direction d − 2 (d·n) n on the second sheet.
SkyView sky_view(const Space& space, const RayEnd& end);

/// Returns the same for a ray that ends at q, relative to `space.center`, with the unit direction d. `radius` is R, or
/// 0 if there is no second sheet.
SkyView sky_view(double radius, const Double3& q, const Double3& d);

}  // namespace kagero

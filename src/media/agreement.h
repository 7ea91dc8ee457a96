/// Checks that the boundaries of a scene agree on the medium of each region.
#pragma once

#include "media/boundaries.h"

namespace kagero {

/// Throws InputError if boundaries state different media for one region. At sample points of each boundary, the medium
/// on each side is compared with that in front of the first boundary on straight rays from there. Points at which
/// another boundary touches the surface within rounding are left out. Returns true if there are such points.
bool check_agreement(const SceneDescription& scene, const Boundaries& boundaries, double unit);

}  // namespace kagero

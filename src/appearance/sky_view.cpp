#include "appearance/sky_view.h"

#include "scene/vector3.h"

namespace kagero {

SkyView sky_view(double throat_radius, const Double3& q, const Double3& d) {
    if (!(length(q) < throat_radius)) return {false, d};
    const Double3 n = unit(q);
    return {true, subtract(d, scaled(n, 2 * dot(d, n)))};
}

SkyView sky_view(const Space& space, const RayEnd& end) {
    return sky_view(space.throat_radius(), {end.q[0], end.q[1], end.q[2]}, {end.v[0], end.v[1], end.v[2]});
}

}  // namespace kagero

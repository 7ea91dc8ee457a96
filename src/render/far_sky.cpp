#include "render/far_sky.h"

#include "scene/vector3.h"

namespace kagero {

SkyView sky_view(double throat, const Double3& q, const Double3& d) {
    if (!(length(q) < 0.5 * throat)) return {false, d};
    const Double3 n = unit(q);
    return {true, subtract(d, scaled(n, 2 * dot(d, n)))};
}

SkyView sky_view(const Plan& plan, const RayEnd& end) {
    double throat = 0;
    if (has_far_sky(plan.scene.space))
        for (const auto& [name, value] : plan.scene.space.parameters)
            if (name == "throat") throat = value;
    return sky_view(throat, {end.q[0], end.q[1], end.q[2]}, {end.v[0], end.v[1], end.v[2]});
}

}  // namespace kagero

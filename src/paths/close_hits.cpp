#include "paths/close_hits.h"

#include "media/regions.h"
#include "scene/vector3.h"

#include <algorithm>

namespace kagero {

void order_close_surfaces(const Plan& plan, std::uint32_t medium, const Double3& start, RayEnd& end) {
    const Regions* regions = plan.scene->regions.get();
    if (!regions || end.status != Status::hit || !regions->close_surfaces().are_close_to(end.surface)) return;
    const Double3 to_scene = subtract(plan.medium(medium).description().space.center, plan.description().space.center),
                  q{end.q[0], end.q[1], end.q[2]};
    const PointOnSurface hit{end.surface, end.primitive, add(q, to_scene)},
        met = regions->close_surfaces().meet(hit, {end.v[0], end.v[1], end.v[2]}, length(subtract(q, start))).first;
    if (met.surface == hit.surface && met.primitive == hit.primitive) return;
    const Double3 position = subtract(met.position, to_scene);
    std::copy(position.begin(), position.end(), end.q);
    end.surface = met.surface;
    end.primitive = met.primitive;
}

}  // namespace kagero

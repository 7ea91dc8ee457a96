/// Conversion of the ends of rays, and of points of their paths, from the kernels to what `trace` reports.
#pragma once

#include "plan/scene.h"

namespace kagero {

/// Converts positions, λ and the integrals to the coordinates and the unit of length of the scene file. `Point` is
/// RayEnd or PathPoint.
template <class Point>
void to_scene_coordinates(const Scene& scene, Point& point) {
    for (std::size_t k = 0; k < 3; ++k) point.q[k] = (point.q[k] + scene.description.space.center[k]) * scene.unit;
    for (double* length : {&point.parameter, &point.action, &point.time}) *length *= scene.unit;
}

/// Replaces the momentum of a ray that started inside the horizon of a black hole by that of the time-reversed ingoing
/// form, in which `trace` prints it. `Point` is RayEnd or PathPoint, in the coordinates of the kernels.
void to_ingoing_form(const Space& space, const RayStart& start, RayEnd& point);
void to_ingoing_form(const Space& space, const RayStart& start, PathPoint& point);

/// Returns the end of a ray that was not traced: the position of its start, without direction and momentum.
RayEnd end_at_start(const RayStart& start, Failure failure);

/// Returns the end that `trace` reports for a ray of a space with the centre and the unit of `scene`, from the end that
/// the kernel has computed.
RayEnd reported_end(const Scene& scene, const Space& space, const RayStart& start, RayEnd end);

}  // namespace kagero

#include "rays/ray_ends.h"

#include "spaces/charts.h"

#include <algorithm>
#include <limits>

namespace kagero {
namespace {

template <class Point>
void convert_to_ingoing_form(const Space& space, const RayStart& start, Point& point) {
    if (!start.ingoing || !is_inside_horizon(space, start.q)) return;
    const Hole hole = space.hole();
    if (is_inside_horizon(space, point.q)) point.pt = -point.pt;
    else space.module->momentum_in_ingoing_form(&hole, point.q, point.p, &point.pt);
}

}  // namespace

void to_ingoing_form(const Space& space, const RayStart& start, RayEnd& point) {
    convert_to_ingoing_form(space, start, point);
}
void to_ingoing_form(const Space& space, const RayStart& start, PathPoint& point) {
    convert_to_ingoing_form(space, start, point);
}

RayEnd end_at_start(const RayStart& start, Failure failure) {
    RayEnd end{};
    std::copy_n(start.q, 3, end.q);
    end.energy_error = std::numeric_limits<double>::quiet_NaN();
    end.status = Status::failed;
    end.failure = failure;
    return end;
}

RayEnd reported_end(const Scene& scene, const Space& space, const RayStart& start, RayEnd end) {
    const bool started =
        end.failure == Failure::none || (start.failure == Failure::none && end.failure != Failure::singular_start);
    if (!started) end = end_at_start(start, end.failure);
    to_ingoing_form(space, start, end);
    to_scene_coordinates(scene, end);
    return end;
}

}  // namespace kagero

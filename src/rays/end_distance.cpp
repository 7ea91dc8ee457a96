#include "rays/end_distance.h"

#include "appearance/sky_view.h"
#include "scene/vector3.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

double angle_between(const Double3& a, const Double3& b) {
    return 2 * std::asin(std::min(1.0, 0.5 * length(subtract(a, b))));
}

}  // namespace

double distance_between(const double (&a)[3], const double (&b)[3]) {
    return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

double angle_between(const double (&a)[3], const double (&b)[3]) {
    return 2 * std::asin(std::min(1.0, 0.5 * distance_between(a, b)));
}

bool is_seen_by_direction(const Plan& plan, const RayEnd& end) {
    return end.status != Status::hit && plan.description().camera.type != CameraType::orthographic;
}

bool has_visible_end(const RayEnd& end) { return end.status == Status::hit || end.status == Status::escaped; }

double pixel_size_at(const Plan& plan, const RayEnd& end) {
    const Double3 &eye = plan.description().camera.position, &center = plan.description().space.center;
    if (is_seen_by_direction(plan, end)) return pixel_size(plan.description(), 1);
    return pixel_size(plan.description(), std::hypot(end.q[0] + center[0] - eye[0], end.q[1] + center[1] - eye[1],
                                                     end.q[2] + center[2] - eye[2]));
}

double distance_in_pixels(const Plan& plan, const RayEnd& expected, const RayEnd& actual) {
    const double size = pixel_size_at(plan, expected);
    if (!is_seen_by_direction(plan, expected)) return distance_between(expected.q, actual.q) / size;
    const Skies& skies = plan.scene->sources.skies;
    const SkyView a = sky_view(skies, expected), b = sky_view(skies, actual);
    // Directions on the skies of different sheets cannot be compared. The directions at the ray ends are used instead.
    const bool on_same_sky = a.on_second_sheet == b.on_second_sheet;
    return on_same_sky ? angle_between(a.direction, b.direction) / size : angle_between(expected.v, actual.v) / size;
}

bool same_status_and_object(const RayEnd& a, const RayEnd& b) {
    if (a.status != b.status || a.cut_off != b.cut_off) return false;
    return a.status != Status::hit || a.surface == b.surface;
}

}  // namespace kagero

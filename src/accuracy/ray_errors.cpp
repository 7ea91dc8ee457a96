#include "accuracy/ray_errors.h"

#include "kernels/assertion.h"
#include "appearance/sky_view.h"
#include "scene/vector3.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kagero {
namespace {

double distance(const double (&a)[3], const double (&b)[3]) {
    return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// Between unit vectors; exact for small angles, unlike the arc cosine.
double angle(const double (&a)[3], const double (&b)[3]) {
    return 2 * std::asin(std::min(1.0, 0.5 * distance(a, b)));
}

double angle(const Double3& a, const Double3& b) {
    return 2 * std::asin(std::min(1.0, 0.5 * length(subtract(a, b))));
}

}  // namespace

bool seen_by_direction(const Plan& plan, const RayEnd& end) {
    return end.status != Status::hit && plan.description().camera.type != CameraType::orthographic;
}

RayEnd in_space(const Plan& plan, RayEnd end) {
    for (std::size_t k = 0; k < 3; ++k) end.q[k] = end.q[k] / plan.scene->unit - plan.description().space.center[k];
    return end;
}

bool has_end(const RayEnd& end) {
    return end.status == Status::hit || end.status == Status::escaped;
}

double pixel_at(const Plan& plan, const RayEnd& end) {
    const Double3 &eye = plan.description().camera.position, &center = plan.description().space.center;
    if (seen_by_direction(plan, end)) return pixel_size(plan.description(), 1);
    return pixel_size(plan.description(), std::hypot(end.q[0] + center[0] - eye[0], end.q[1] + center[1] - eye[1],
                                                     end.q[2] + center[2] - eye[2]));
}

double pixels_apart(const Plan& plan, const RayEnd& should, const RayEnd& is) {
    const double size = pixel_at(plan, should);
    if (!seen_by_direction(plan, should)) return distance(should.q, is.q) / size;
    const SkyView a = sky_view(plan.scene->space, should), b = sky_view(plan.scene->space, is);
    return a.far == b.far ? angle(a.direction, b.direction) / size : angle(should.v, is.v) / size;
}

double pixel_error(const Plan& plan, const RayEnd& should, const RayEnd& is) {
    constexpr double not_known = std::numeric_limits<double>::quiet_NaN();
    if (!same_class(should, is)) return not_known;
    if (should.status == Status::captured) return 0;
    return has_end(should) ? pixels_apart(plan, should, is) : not_known;
}

bool same_class(const RayEnd& a, const RayEnd& b) {
    if (a.status != b.status) return false;
    return a.status != Status::hit || a.surface == b.surface;
}

RayErrors compare_rays(const Plan& plan, const ReferenceRays& reference,
                       const std::vector<RayEnd>& ends) {
    KAGERO_ASSERT(ends.size() == reference.ends.size() && ends.size() == reference.conditioning.size());
    RayErrors errors;
    std::vector<double> position, direction, pixels, ill;
    for (std::size_t i = 0; i < ends.size(); ++i) {
        const RayEnd &should = reference.ends[i], &is = ends[i];
        if (!reference.decided[i]) continue;
        if (!same_class(should, is)) {
            ++errors.flips;
            continue;
        }
        if (!has_end(should)) continue;
        const double displaced = pixels_apart(plan, in_space(plan, should), in_space(plan, is)),
                     conditioning = reference.conditioning[i];
        pixels.push_back(displaced / std::max(1.0, conditioning / ill_conditioned));
        if (conditioning > ill_conditioned) {
            ill.push_back(displaced / conditioning);
            continue;
        }
        position.push_back(distance(should.q, is.q));
        direction.push_back(angle(should.v, is.v));
    }
    errors.compared = position.size(), errors.ill = ill.size();
    const auto above = std::count_if(pixels.begin(), pixels.end(), [](double error) { return error > 0.25; });
    errors.above_quarter_pixel = double(above) / double(pixels.size());
    errors.position = spread_of(std::move(position));
    errors.direction = spread_of(std::move(direction));
    errors.pixels = spread_of(std::move(pixels));
    errors.ill_pixels = spread_of(std::move(ill));
    return errors;
}

std::vector<double> conditioning_of(const Plan& plan, const SampleRays& sample, const std::vector<RayEnd>& ends,
                                    const std::vector<RayEnd>& right, const std::vector<RayEnd>& below) {
    std::vector<double> all(ends.size());
    for (std::size_t i = 0; i < ends.size(); ++i)
        for (const RayEnd* aside : {&right[i], &below[i]}) {
            // A neighbour that ends otherwise may be beside an edge only; that alone does not make a ray
            // ill-conditioned.
            if (!has_end(ends[i]) || !same_class(ends[i], *aside)) continue;
            const double seen =
                pixels_apart(plan, in_space(plan, ends[i]), in_space(plan, *aside)) * sample.pixel_angle;
            // Parallel rays are set aside by a length, which says nothing of how an angle compares with it.
            const double turned = plan.description().camera.type == CameraType::orthographic
                                      ? 0
                                      : angle(ends[i].v, aside->v),
                         apart = std::max(turned, seen);
            all[i] = std::max(all[i], apart / sample.turn);
        }
    return all;
}

}  // namespace kagero

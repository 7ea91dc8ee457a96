#include "accuracy/ray_errors.h"

#include "appearance/sky_view.h"
#include "kernels/assertion.h"
#include "scene/vector3.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kagero {
namespace {

double distance(const double (&a)[3], const double (&b)[3]) {
    return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// Returns the angle between two unit vectors. The arc sine is accurate for small angles, unlike the arc cosine.
double angle(const double (&a)[3], const double (&b)[3]) { return 2 * std::asin(std::min(1.0, 0.5 * distance(a, b))); }

double angle(const Double3& a, const Double3& b) { return 2 * std::asin(std::min(1.0, 0.5 * length(subtract(a, b)))); }

}  // namespace

bool is_seen_by_direction(const Plan& plan, const RayEnd& end) {
    return end.status != Status::hit && plan.description().camera.type != CameraType::orthographic;
}

RayEnd to_hamiltonian_coordinates(const Plan& plan, RayEnd end) {
    for (std::size_t k = 0; k < 3; ++k) end.q[k] = end.q[k] / plan.scene->unit - plan.description().space.center[k];
    return end;
}

std::size_t confirm(ReferenceRays& reference, const std::vector<RayEnd>& confirming) {
    reference.confirmed.clear();
    for (std::size_t i = 0; i < reference.ends.size(); ++i) {
        const RayEnd& end = reference.ends[i];
        const bool is_definite = (end.status != Status::step_limit || end.cut_off) && end.status != Status::failed;
        reference.confirmed.push_back(is_definite && same_status_and_object(end, confirming[i]));
    }
    return std::size_t(std::count(reference.confirmed.begin(), reference.confirmed.end(), false));
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
    if (!is_seen_by_direction(plan, expected)) return distance(expected.q, actual.q) / size;
    const Skies& skies = plan.scene->sources.skies;
    const SkyView a = sky_view(skies, expected), b = sky_view(skies, actual);
    // Directions on the skies of different sheets cannot be compared. The directions at the ray ends are used instead.
    const bool on_same_sky = a.on_second_sheet == b.on_second_sheet;
    return on_same_sky ? angle(a.direction, b.direction) / size : angle(expected.v, actual.v) / size;
}

double pixel_error(const Plan& plan, const RayEnd& expected, const RayEnd& actual) {
    constexpr double undefined = std::numeric_limits<double>::quiet_NaN();
    if (!same_status_and_object(expected, actual)) return undefined;
    if (expected.status == Status::captured || expected.cut_off) return 0;
    return has_visible_end(expected) ? distance_in_pixels(plan, expected, actual) : undefined;
}

bool same_status_and_object(const RayEnd& a, const RayEnd& b) {
    if (a.status != b.status || a.cut_off != b.cut_off) return false;
    return a.status != Status::hit || a.surface == b.surface;
}

RayErrors compare_rays(const Plan& plan, const ReferenceRays& reference, const std::vector<RayEnd>& ends) {
    KAGERO_ASSERT(ends.size() == reference.ends.size() && ends.size() == reference.conditioning.size());
    RayErrors errors;
    std::vector<double> position, direction, pixels, ill_conditioned_pixels;
    for (std::size_t i = 0; i < ends.size(); ++i) {
        const RayEnd &expected = reference.ends[i], &actual = ends[i];
        if (!reference.confirmed[i]) continue;
        if (!same_status_and_object(expected, actual)) {
            ++errors.flips;
            continue;
        }
        if (!has_visible_end(expected)) continue;
        const double error_in_pixels = distance_in_pixels(plan, to_hamiltonian_coordinates(plan, expected),
                                                          to_hamiltonian_coordinates(plan, actual)),
                     conditioning = reference.conditioning[i];
        pixels.push_back(error_in_pixels / std::max(1.0, conditioning / conditioning_limit));
        if (conditioning > conditioning_limit) {
            ill_conditioned_pixels.push_back(error_in_pixels / conditioning);
            continue;
        }
        position.push_back(distance(expected.q, actual.q));
        direction.push_back(angle(expected.v, actual.v));
    }
    errors.compared = position.size();
    errors.compared_ill_conditioned = ill_conditioned_pixels.size();
    const auto count = std::count_if(pixels.begin(), pixels.end(), [](double error) { return error > 0.25; });
    errors.above_quarter_pixel = double(count) / double(pixels.size());
    errors.position = percentiles_of(std::move(position));
    errors.direction = percentiles_of(std::move(direction));
    errors.pixels = percentiles_of(std::move(pixels));
    errors.ill_conditioned_pixels = percentiles_of(std::move(ill_conditioned_pixels));
    return errors;
}

std::vector<double> conditioning_of(const Plan& plan, const SampleRays& sample, const std::vector<RayEnd>& ends,
                                    const std::vector<RayEnd>& right, const std::vector<RayEnd>& below) {
    std::vector<double> conditioning_of_rays(ends.size());
    for (std::size_t i = 0; i < ends.size(); ++i)
        for (const RayEnd* neighbour : {&right[i], &below[i]}) {
            // A neighbour with another status or object is ignored: the edge of an object may lie between the two rays.
            if (!has_visible_end(ends[i]) || !same_status_and_object(ends[i], *neighbour)) continue;
            const double shift = distance_in_pixels(plan, to_hamiltonian_coordinates(plan, ends[i]),
                                                    to_hamiltonian_coordinates(plan, *neighbour)) *
                                 sample.pixel_angle;
            // The neighbours of an orthographic camera's rays are shifted by a length, not turned by an angle.
            const double angle_of_ends = plan.description().camera.type == CameraType::orthographic
                                             ? 0
                                             : angle(ends[i].v, neighbour->v),
                         separation = std::max(angle_of_ends, shift);
            conditioning_of_rays[i] = std::max(conditioning_of_rays[i], separation / sample.neighbour_angle);
        }
    return conditioning_of_rays;
}

}  // namespace kagero

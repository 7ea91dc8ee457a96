#include "accuracy/ray_errors.h"

#include "kernels/assertion.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kagero {

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

double pixel_error(const Plan& plan, const RayEnd& expected, const RayEnd& actual) {
    constexpr double undefined = std::numeric_limits<double>::quiet_NaN();
    if (!same_status_and_object(expected, actual)) return undefined;
    if (expected.status == Status::captured || expected.cut_off) return 0;
    return has_visible_end(expected) ? distance_in_pixels(plan, expected, actual) : undefined;
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
        position.push_back(distance_between(expected.q, actual.q));
        direction.push_back(angle_between(expected.v, actual.v));
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
                                             : angle_between(ends[i].v, neighbour->v),
                         separation = std::max(angle_of_ends, shift);
            conditioning_of_rays[i] = std::max(conditioning_of_rays[i], separation / sample.neighbour_angle);
        }
    return conditioning_of_rays;
}

}  // namespace kagero

#include "tuning/step_bound.h"

#include "accuracy/ray_errors.h"
#include "error.h"
#include "rays/camera.h"
#include "render/operation_count.h"
#include "render/trace.h"
#include "scene/vector3.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

/// Number of film rays along each edge of the grid, and number of rays through the region of the camera.
constexpr std::uint32_t bound_grid = 8, volume_rays = 64;
/// Bounds that are tried, as shares of the escape radius, and the smallest bound, with which they are compared. The
/// stages of a step lie closer together than a tenth of its length.
constexpr double step_shares[] = {std::numeric_limits<double>::infinity(), 1.0 / 8, 1.0 / 64};
constexpr double smallest_share = 1.0 / 512;
/// Greatest difference of two ray ends that agree: an angle in radians, and a share of the escape radius.
constexpr double max_end_difference = 1e-6;
/// Greatest tolerance of the traces, so that errors of the steps are below `max_end_difference`.
constexpr double bound_tolerance = 1e-8;
/// Limit of steps: a ray covers at most four escape radii with the smallest bound.
constexpr std::uint32_t max_bound_steps = 2048;

/// Returns element i of the van der Corput sequence, which fills (0, 1) evenly.
double van_der_corput(std::uint32_t i, std::uint32_t base) {
    double value = 0, share = 1;
    for (; i > 0; i /= base) value += double(i % base) * (share /= base);
    return value;
}

/// Returns rays with positions and directions that fill the ball around the centre of the space through the camera, or
/// the escape sphere if the camera is at the centre or outside.
std::vector<RayStart> rays_through_volume(const Scene& scene) {
    const Double3 camera = subtract(scene.description.camera.position, scene.description.space.center);
    const double escape_radius = scene.description.integrator.escape_radius, distance = length(camera);
    const double radius = distance > 0 && distance < escape_radius ? distance : escape_radius;
    std::vector<RayStart> rays;
    for (std::uint32_t i = 1; i <= volume_rays; ++i) {
        const auto coordinate = [&](std::uint32_t base) { return 2 * van_der_corput(i, base) - 1; };
        const double q[3] = {radius * coordinate(2), radius * coordinate(3), radius * coordinate(5)};
        const RayStart ray = scene.space.start(q, {coordinate(7), coordinate(11), coordinate(13)});
        if (ray.failure == Failure::none) rays.push_back(ray);
    }
    return rays;
}

std::vector<RayStart> trial_rays(const Plan& plan, const Options& options, Purpose purpose) {
    Plan picture = plan;
    std::vector<RayStart> rays;
    if (purpose == Purpose::ray_list) {
        rays = rays_through_volume(*plan.scene);
        try {
            picture.view = make_camera_view(*plan.scene, options);
        } catch (const InputError&) {  // a ray list needs no camera
            return rays;
        }
    }
    for (const auto& [x, y] : sample_pixels(plan.description().film, bound_grid, bound_grid))
        rays.push_back(camera_ray_start(picture, x, y));
    return rays;
}

/// Returns true if the ends have the same status and agree in position and direction.
bool agree(const RayEnd& a, const RayEnd& b, double escape_radius) {
    if (!same_status_and_object(a, b)) return false;
    if (!has_visible_end(a)) return true;
    const double angle = std::hypot(a.v[0] - b.v[0], a.v[1] - b.v[1], a.v[2] - b.v[2]),
                 distance = std::hypot(a.q[0] - b.q[0], a.q[1] - b.q[1], a.q[2] - b.q[2]);
    return angle <= max_end_difference && distance <= max_end_difference * escape_radius;
}

}  // namespace

Plan choose_step_bound(Plan plan, const Options& options, Purpose purpose, const RunControl& control) {
    const auto& formula = plan.description().space.formula;
    if (!formula || formula->parsed.length_scale >= 0 || !plan.method().adaptive || plan.scene->straight) return plan;
    const double escape_radius = plan.description().integrator.escape_radius;
    const std::vector<RayStart> starts = trial_rays(plan, options, purpose);
    if (starts.empty()) return plan;
    const auto ends_with = [&](double share) {
        Plan bounded = plan;
        bounded.run.tolerance = std::min(plan.run.tolerance, bound_tolerance);
        bounded.run.max_step_length = share * escape_radius;
        bounded.run.max_steps = max_bound_steps;
        std::vector<RayEnd> ends;
        const RunReport report = trace(bounded, starts, ends, {.stop = control.stop});
        if (report.interrupted) throw Interrupted();
        plan.trial_operations += operations_of(bounded, report.counters);
        return ends;
    };
    const std::vector<RayEnd> expected = ends_with(smallest_share);
    double chosen = smallest_share;
    for (const double share : step_shares) {
        const std::vector<RayEnd> ends = ends_with(share);
        const auto same = [&](const RayEnd& a, const RayEnd& b) { return agree(a, b, escape_radius); };
        if (!std::equal(expected.begin(), expected.end(), ends.begin(), same)) continue;
        chosen = share;
        break;
    }
    plan.run.max_step_length = chosen * escape_radius;
    plan.decisions.tuning.push_back(
        {std::isfinite(chosen)
             ? "step bound of " + plain_number(plan.run.max_step_length) + ": with longer steps, some of " +
                   std::to_string(starts.size()) + " rays pass over features of H"
             : "step bound",
         std::isfinite(chosen),
         std::isfinite(chosen) ? ""
                               : "without one, the ends of " + std::to_string(starts.size()) +
                                     " rays are the same as with steps of at most " +
                                     plain_number(smallest_share * escape_radius)});
    return plan;
}

}  // namespace kagero

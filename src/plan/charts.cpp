#include "plan/charts.h"

#include "error.h"
#include "plan/names.h"
#include "scene/value.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

/// Near an extreme hole, prograde light can turn so close to the horizon that it winds up in outgoing coordinates.
constexpr double near_extreme_spin = 0.99;
/// Least distance of a surface outside the horizon from the horizon's equator, as a fraction of its radius |q|.
constexpr double least_gap = 1e-3;

double horizon_radius(const Hole& hole) {
    return hole.mass + std::sqrt(std::max(hole.mass * hole.mass - hole.spin * hole.spin, 0.0));
}

Spheroid horizon_of(const Hole& hole) {
    const double radius = horizon_radius(hole);
    return {std::hypot(radius, hole.spin), radius};
}

/// Returns the distance from the centre to the nearest surface outside the horizon; infinity if there is none.
double distance_to_outer_surfaces(const Scene& scene, const Spheroid& horizon) {
    double distance = std::numeric_limits<double>::infinity();
    const auto count = static_cast<std::uint32_t>(scene.geometry->objects().size());
    for (std::uint32_t i = 0; i < count; ++i) {
        // In a spheroid that is flatter than a sphere, the equator is the greatest distance.
        if (scene.geometry->range_of(i, horizon).greatest < 1) continue;
        distance = std::min(distance, scene.geometry->range_of(i, {1, 1}).least);
    }
    return distance;
}

}  // namespace

bool is_inside_horizon(const Scene& scene, const double (&q)[3]) {
    const Hole hole = scene.space.hole();
    return hole.mass > 0 && scene.module().hole_radius(&hole, q) <= horizon_radius(hole);
}

std::optional<Spheroid> horizon_of_spinning_hole(const Space& space) {
    const Hole hole = space.hole();
    return hole.mass > 0 && hole.spin != 0 ? std::optional(horizon_of(hole)) : std::nullopt;
}

double chart_radius(const Scene& scene) {
    const Hole hole = scene.space.hole();
    if (!(hole.mass > 0)) return 0;
    const Spheroid horizon = horizon_of(hole);
    // Without spin, positions are the same in both charts, so that surfaces do not matter.
    const double surfaces = hole.spin == 0 ? std::numeric_limits<double>::infinity()
                                           : (1 - least_gap) * distance_to_outer_surfaces(scene, horizon);
    const double radius = std::min(2 * horizon.pole, surfaces);
    return radius > (1 + least_gap) * horizon.equator ? radius : 0;
}

bool starts_ingoing(const Scene& scene, std::optional<ObserverKind> observer, const double (&q)[3]) {
    const Hole hole = scene.space.hole();
    if (!(hole.mass > 0)) return false;
    if (is_inside_horizon(scene, q)) return observer == ObserverKind::falling;
    return std::hypot(q[0], q[1], q[2]) < scene.limits.chart_radius &&
           (hole.spin != 0 || observer == ObserverKind::falling);
}

bool chart_changes_on_the_way(const Scene& scene, const View& view) {
    const Hole hole = scene.space.hole();
    if (hole.spin == 0 || !(hole.mass > 0)) return false;
    if (std::abs(hole.spin) > near_extreme_spin * hole.mass) return true;
    if (!scene.geometry->kernel_view()) return false;
    return !view.has_camera || scene.description.camera.type == CameraType::orthographic || view.camera.start.ingoing;
}

void check_surfaces_at_horizon(const Scene& scene, Purpose purpose) {
    const Hole hole = scene.space.hole();
    if (!(hole.mass > 0)) return;
    const Spheroid horizon = horizon_of(hole);
    double camera[3];
    for (std::size_t k = 0; k < 3; ++k)
        camera[k] = scene.description.camera.position[k] - scene.description.space.center[k];
    const bool inside = is_inside_horizon(scene, camera);
    for (std::uint32_t i = 0; i < scene.geometry->objects().size(); ++i) {
        const ObjectDescription& object = scene.description.objects[i];
        const SpheroidRange range = scene.geometry->range_of(i, horizon);
        const bool crosses = range.least <= 1 && range.greatest >= 1;
        if (purpose == Purpose::picture && !inside && range.least <= 1)
            throw InputError(object.location,
                             "object " + object.name +
                                 " reaches into the horizon of the black hole, and no light from there comes to a camera "
                                 "outside; move it outside r = " +
                                 to_toml(horizon.pole * scene.unit) + ", or the camera inside");
        if (hole.spin == 0 || (!crosses && (range.greatest < 1 || scene.limits.chart_radius > 0 || !inside))) continue;
        if (crosses || inside)
            throw InputError(object.location,
                             "object " + object.name + " touches the horizon r = " + to_toml(horizon.pole * scene.unit) +
                                 " of a spinning hole, or almost touches it: positions inside are in other coordinates "
                                 "than positions outside; move it");
    }
}

}  // namespace kagero

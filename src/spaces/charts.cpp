#include "spaces/charts.h"

#include "error.h"
#include "scene/value.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kagero {
namespace {

/// Least |spin|/M of a nearly extreme hole.
constexpr double nearly_extreme_spin = 0.99;
/// Least distance of a surface outside the horizon from its equator, as a fraction of the equator's radius.
constexpr double least_gap = 1e-3;

/// Returns the distance from the centre to the nearest surface outside the horizon; infinity if there is none.
double distance_to_outer_surfaces(const SceneGeometry& geometry, const Spheroid& horizon) {
    double distance = std::numeric_limits<double>::infinity();
    for (std::uint32_t i = 0; i < geometry.objects().size(); ++i)
        if (geometry.range_of(i, horizon).greatest >= 1)
            distance = std::min(distance, geometry.range_of(i, {1, 1}).least);
    return distance;
}

}  // namespace

std::optional<Spheroid> horizon_of(const Space& space) {
    const Hole hole = space.hole();
    if (!(hole.mass > 0)) return std::nullopt;
    const double radius = hole.mass + std::sqrt(std::max(hole.mass * hole.mass - hole.spin * hole.spin, 0.0));
    return Spheroid{std::hypot(radius, hole.spin), radius};
}

std::optional<Spheroid> horizon_of_spinning_hole(const Space& space) {
    return space.hole().spin != 0 ? horizon_of(space) : std::nullopt;
}

bool is_inside_horizon(const Space& space, const double (&q)[3]) {
    const auto horizon = horizon_of(space);
    const Hole hole = space.hole();
    return horizon && space.module->hole_radius(&hole, q) <= horizon->pole;
}

bool is_nearly_extreme(const Space& space) {
    const Hole hole = space.hole();
    return std::abs(hole.spin) > nearly_extreme_spin * hole.mass;
}

double chart_radius(const Space& space, const SceneGeometry& geometry) {
    const auto horizon = horizon_of(space);
    if (!horizon) return 0;
    // Without spin, positions are the same in both charts, so that surfaces do not matter.
    const bool spins = space.hole().spin != 0;
    const double innermost_surface = spins ? (1 - least_gap) * distance_to_outer_surfaces(geometry, *horizon)
                                           : std::numeric_limits<double>::infinity(),
                 radius = std::min(2 * horizon->pole, innermost_surface);
    return radius > (1 + least_gap) * horizon->equator ? radius : 0;
}

bool starts_ingoing(const Space& space, double chart_radius, std::optional<ObserverKind> observer,
                    const double (&q)[3]) {
    const Hole hole = space.hole();
    // The equator of the horizon has a radius of at most 2M.
    const double distance2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2], greatest = std::max(2 * hole.mass, chart_radius);
    if (!(distance2 <= greatest * greatest)) return false;
    const bool falling = observer == ObserverKind::falling;
    if (is_inside_horizon(space, q)) return falling;
    return std::sqrt(distance2) < chart_radius && (falling || hole.spin != 0);
}

Double3 start_position(const Space& space, const RayStart& start) {
    RayStart converted = start;
    const Hole hole = space.hole();
    if (start.ingoing) space.module->to_scene(&hole, converted.q, converted.p, &converted.pt);
    return {converted.q[0], converted.q[1], converted.q[2]};
}

void check_surfaces_at_horizon(const Space& space, const SceneGeometry& geometry,
                               const std::vector<ObjectDescription>& objects, const double* camera, double unit) {
    const auto horizon = horizon_of(space);
    if (!horizon) return;
    const bool spins = space.hole().spin != 0,
               camera_is_inside = camera && is_inside_horizon(space, {camera[0], camera[1], camera[2]});
    const std::string radius = "r = " + to_toml(horizon->pole * unit);
    for (std::uint32_t i = 0; i < objects.size(); ++i) {
        const SpheroidRange range = geometry.range_of(i, *horizon);
        if (camera && !camera_is_inside && range.greatest < 1)
            throw InputError(objects[i].location,
                             "object " + objects[i].name + " lies inside the horizon, " + radius +
                                 ", from which no light comes to a camera outside. Move the object outside, or the "
                                 "camera inside");
        if (spins && camera_is_inside && range.greatest >= 1 &&
            geometry.range_of(i, {1, 1}).least <= (1 + least_gap) * horizon->equator)
            throw InputError(objects[i].location,
                             "object " + objects[i].name + " touches the horizon of a spinning hole, " + radius +
                                 ", or almost touches it. For a camera inside, positions inside are in other "
                                 "coordinates than positions outside; move the object");
    }
}

}  // namespace kagero

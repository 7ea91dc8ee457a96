#include "appearance/redshift.h"

#include "scene/value.h"
#include "scene/vector3.h"

#include <algorithm>

namespace kagero {
namespace {

/// Returns g for a ray that ends on a disk (see redshift_of). Not inlined, because most rays end elsewhere.
[[gnu::noinline]] double redshift_of_disk(const Space& space, const PixelSample& ray, const ObjectDescription& disk) {
    const RayEnd& end = *ray.end;
    const double emitted = space.frequency(end, orbit_velocity(space, disk.normal, {end.q[0], end.q[1], end.q[2]}));
    return emitted > 0 ? ray.ray->frequency / emitted : 0;
}

}  // namespace

Double3 orbit_velocity(const Space& space, const Double3& normal, const Double3& q) {
    const Hole hole = space.hole();
    if (hole.mass == 0) return {0, 0, 0};
    const Double3 axis = unit(normal);
    // In the equatorial plane of Kerr-Schild coordinates, |q|² = r² + a², with the Boyer-Lindquist radius r.
    const double radius_squared = std::max(0.0, dot(q, q) - hole.spin * hole.spin);
    const double root_mass = std::sqrt(hole.mass), spin = axis[2] < 0 ? -hole.spin : hole.spin;
    return scaled(cross(axis, q), root_mass / (std::pow(radius_squared, 0.75) + spin * root_mass));
}

double redshift_of(const Space& space, bool spacetime, const std::vector<ObjectDescription>& objects,
                   const PixelSample& ray) {
    const RayEnd& end = *ray.end;
    if (end.status == Status::hit) {
        const ObjectDescription& object = objects[end.surface];
        return object.shape == Shape::disk ? redshift_of_disk(space, ray, object) : 0;
    }
    if (end.status != Status::escaped) return 0;
    if (!spacetime) return 1;
    return end.pt != 0 ? ray.ray->frequency / std::abs(end.pt) : 0;
}

void check_disks(const Space& space, const SceneDescription& scene, double length_unit) {
    const Hole hole = space.hole();
    if (hole.mass == 0) return;
    for (const ObjectDescription& object : scene.objects) {
        if (object.shape != Shape::disk) continue;
        const std::string name = "object." + object.name;
        if (const Double3& center = scene.space.center; object.center != center)
            throw InputError(object.center_location,
                             name + ".center = " + to_toml(scaled(object.center, length_unit)) +
                                 ": expected space.center = " + to_toml(scaled(center, length_unit)) +
                                 ", because the matter of a disk orbits the hole");
        const Double3 axis = unit(object.normal);
        if (hole.spin != 0 && (axis[0] != 0 || axis[1] != 0))
            throw InputError(object.normal_location,
                             name + ".normal = " + to_toml(object.normal) +
                                 ": expected a vector along z, because a spinning hole has circular orbits only in its "
                                 "equatorial plane");
    }
}

}  // namespace kagero

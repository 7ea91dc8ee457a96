#include "appearance/redshift.h"

#include "scene/value.h"
#include "scene/vector3.h"

#include <algorithm>

namespace kagero {
namespace {

/// Of a space as the scene has it, whichever way the time of the plan's rays runs.
Hole hole_of(const Plan& plan) {
    Hole hole = plan.module->hole(plan.hamiltonian, plan.parameters.data());
    hole.spin *= plan.time;
    return hole;
}

double frequency(const Plan& plan, const RayEnd& end, const Double3& velocity) {
    return plan.module->frequency(plan.hamiltonian, plan.parameters.data(), end.q, end.p, end.pt, velocity.data(), plan.time);
}

/// Not inlined: most rays end elsewhere.
[[gnu::noinline]] double redshift_of_disk(const Plan& plan, const Sighting& ray, const ObjectDescription& disk) {
    const RayEnd& end = *ray.end;
    const double sent = frequency(plan, end, orbit_velocity(plan, disk.normal, {end.q[0], end.q[1], end.q[2]}));
    return sent > 0 ? ray.ray->frequency / sent : 0;
}

}  // namespace

Double3 orbit_velocity(const Plan& plan, const Double3& normal, const Double3& q) {
    const Hole hole = hole_of(plan);
    if (hole.mass == 0) return {0, 0, 0};
    const Double3 axis = unit(normal);
    // On the equator |q|² = r² + a².
    const double radius2 = std::max(0.0, dot(q, q) - hole.spin * hole.spin);
    const double root = std::sqrt(hole.mass), spin = axis[2] < 0 ? -hole.spin : hole.spin;
    return scaled(cross(axis, q), root / (std::pow(radius2, 0.75) + spin * root));
}

double redshift_of(const Plan& plan, const Sighting& ray) {
    const RayEnd& end = *ray.end;
    if (end.status == Status::hit) {
        const ObjectDescription& object = plan.scene.objects[end.surface];
        return object.shape == Shape::disk ? redshift_of_disk(plan, ray, object) : 0;
    }
    if (end.status != Status::escaped) return 0;
    if (!plan.spacetime) return 1;
    return end.pt != 0 ? ray.ray->frequency / std::abs(end.pt) : 0;
}

void check_disks(const Plan& plan) {
    const Hole hole = hole_of(plan);
    if (hole.mass == 0) return;
    for (const ObjectDescription& object : plan.scene.objects) {
        if (object.shape != Shape::disk) continue;
        const std::string name = "object." + object.name;
        if (const Double3& center = plan.scene.space.center; object.center != center)
            throw InputError(object.center_place, name + ".center = " + written(scaled(object.center, plan.unit)) + ": expected space.center, " +
                                                      written(scaled(center, plan.unit)) + ", as a disk's matter orbits the hole");
        const Double3 axis = unit(object.normal);
        if (hole.spin != 0 && (axis[0] != 0 || axis[1] != 0))
            throw InputError(object.normal_place, name + ".normal = " + written(object.normal) +
                                                      ": expected one along z, as a spinning hole has circular orbits in its equator alone");
    }
}

}  // namespace kagero

#include "appearance/redshift.h"

#include "geometry/shapes.h"
#include "scene/value.h"
#include "scene/vector3.h"
#include "spaces/rest_frame.h"
#include "spaces/velocity.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <sstream>

namespace kagero {
namespace {

/// Returns a number with six digits.
std::string shortened(double x) {
    std::ostringstream out;
    out << x;
    return out.str();
}

/// Returns the frequency of the light of a ray for the matter of the disk on which it ends; NaN if the matter is not
/// slower than light.
double emitted_frequency(const Sources& sources, const RayEnd& end) {
    const Space& space = *sources.space;
    const ObjectDescription& disk = (*sources.objects)[end.surface];
    if (disk.velocity) return space.frequency(end, velocity_at(*disk.velocity, end.q));
    const Double3 q{end.q[0], end.q[1], end.q[2]};
    if (!sources.orbits.empty()) {
        const double emitted = space.frequency(end, sources.orbits[end.surface].velocity(q));
        return emitted > 0 ? emitted : space.frequency(end, {0, 0, 0});
    }
    const Double3 v = orbit_velocity(space, disk.normal, q);
    const double dilation = sources.dilations.empty() ? std::numeric_limits<double>::quiet_NaN()
                                                      : sources.dilations[end.surface].at(length(q));
    if (dilation > 0) return dilation * (dot(v, {end.p[0], end.p[1], end.p[2]}) + end.pt);
    return space.frequency(end, v);
}

/// Returns the time dilation of the matter of a disk around a built-in hole, as a function of the distance from the
/// centre: the frequency of light without momentum and with p_t = 1. Around the axis, it does not depend on the angle.
TimeDilation dilation_in_disk(const Space& space, const ObjectDescription& disk) {
    const Double3 outward = axes_around(unit(disk.normal))[0];
    return {disk.inner, disk.outer, [&](double distance) {
                const Double3 q = scaled(outward, distance);
                RayEnd light{};
                std::copy(q.begin(), q.end(), light.q);
                light.pt = 1;
                return space.frequency(light, orbit_velocity(space, disk.normal, q));
            }};
}

/// Returns the frequency of the light of a ray for the camera's observer, with the momentum at the ray's end.
double observed_frequency(const PixelSample& ray) { return ray.ray->frequency * (ray.path ? ray.path->frequency : 1); }

/// Returns g for a ray that ends on a disk (see redshift_of). Not inlined, because most rays end elsewhere.
[[gnu::noinline]] double redshift_of_disk(const Sources& sources, const PixelSample& ray) {
    if (ray.path && ray.path->medium != 0) return observed_frequency(ray);  // matter in a medium is at rest
    const double emitted = emitted_frequency(sources, *ray.end);
    return emitted > 0 ? observed_frequency(ray) / emitted : 0;
}

/// Returns the distances from the centre at which the velocity of a disk is tested.
std::vector<double> test_radii(const ObjectDescription& disk) {
    constexpr int count = 33;
    std::vector<double> radii;
    for (int i = 0; i < count; ++i) radii.push_back(disk.inner + (disk.outer - disk.inner) * i / (count - 1));
    return radii;
}

/// Calls visit(q, g, v) at test points of a disk with a stated velocity v where there is a metric g. The points q are
/// relative to the centre of the space.
template <class Visit>
void visit_matter(const Space& space, const SceneDescription& scene, const ObjectDescription& disk, double radius,
                  const Visit& visit) {
    constexpr int angles = 8;
    const auto [e1, e2] = axes_around(unit(disk.normal));
    for (int i = 0; i < angles; ++i) {
        const double angle = 2 * std::numbers::pi * i / angles;
        const Double3 p = add(subtract(disk.center, scene.space.center),
                              add(scaled(e1, radius * std::cos(angle)), scaled(e2, radius * std::sin(angle))));
        const double q[3] = {p[0], p[1], p[2]};
        SpacetimeMatrix g;
        if (metric_at(space, q, g) == Failure::none) visit(q, g, velocity_at(*disk.velocity, q));
    }
}

/// Throws InputError if the stated velocity of a disk is not below the speed of light at any test point.
void check_stated_velocity(const Space& space, const SceneDescription& scene, const ObjectDescription& disk,
                           double length_unit) {
    std::string problem;
    bool exists = false;
    for (const double radius : test_radii(disk))
        visit_matter(space, scene, disk, radius, [&](const double(&q)[3], const SpacetimeMatrix& g, const Double3& v) {
            if (rest_frame(g, v)) exists = true;
            else if (problem.empty())
                problem = text_of(*disk.velocity, q) + " is not slower than light at " +
                          to_toml(scaled({q[0], q[1], q[2]}, length_unit)) + ": " + speed_limit(g, v);
        });
    if (!exists && !problem.empty())
        throw InputError(disk.velocity->location, "object." + disk.name + ".velocity = " + problem);
}

/// Returns a remark on the part of a disk whose stated velocity is not below the speed of light; "" if there is none.
std::string remark_on_stated_velocity(const Space& space, const SceneDescription& scene, const ObjectDescription& disk,
                                      double length_unit) {
    double least = std::numeric_limits<double>::infinity(), greatest = 0;
    for (const double radius : test_radii(disk))
        visit_matter(space, scene, disk, radius, [&](const double(&)[3], const SpacetimeMatrix& g, const Double3& v) {
            if (rest_frame(g, v)) return;
            least = std::min(least, radius);
            greatest = std::max(greatest, radius);
        });
    if (greatest == 0) return "";
    return "object." + disk.name + ": its velocity is not slower than light at distances from " +
           to_toml(least * length_unit) + " to " + to_toml(greatest * length_unit) +
           " from its centre; the disk is dark there";
}

/// Returns a remark on the part of a disk without circular orbits; "" if there is none.
std::string remark_on_orbits(const ObjectDescription& disk, const CircularOrbits& orbits, double length_unit) {
    const std::string at_rest = "object." + disk.name + ": the matter of the disk is at rest";
    const std::string remedy = "; state object." + disk.name + ".velocity";
    if (!orbits.refusal().empty()) return at_rest + ", because " + orbits.refusal() + remedy;
    const std::string ranges = ranges_at_rest(orbits, length_unit);
    if (ranges.empty()) return "";
    return at_rest + " at distances " + ranges + " from its centre, because there are no circular orbits" + remedy;
}

}  // namespace

Double3 orbit_velocity(const Space& space, const Double3& normal, const Double3& q) {
    const Hole hole = space.hole();
    if (hole.mass == 0) return {0, 0, 0};
    const Double3 axis = unit(normal);
    // In the equatorial plane of Kerr-Schild coordinates, |q|² = r² + a², with the Boyer-Lindquist radius r.
    const double radius_squared = std::max(0.0, dot(q, q) - hole.spin * hole.spin);
    const double radius = std::sqrt(radius_squared), root_mass = std::sqrt(hole.mass),
                 spin = axis[2] < 0 ? -hole.spin : hole.spin;
    return scaled(cross(axis, q), root_mass / (radius * std::sqrt(radius) + spin * root_mass));
}

double redshift_of(const Sources& sources, bool spacetime, const PixelSample& ray) {
    const RayEnd& end = *ray.end;
    if (end.status == Status::hit)
        return (*sources.objects)[end.surface].shape == Shape::disk ? redshift_of_disk(sources, ray) : 0;
    if (end.status != Status::escaped) return 0;
    if (!spacetime) return 1;
    const double emitted = ray.sky.frequency > 0 ? ray.sky.frequency : frequency_at_sky(sources.skies, end);
    return emitted > 0 ? observed_frequency(ray) / emitted : 0;
}

Sources make_sources(const Space& space, const SceneDescription& scene, bool with_orbits) {
    Sources sources{&space, &scene.objects, make_skies(space, scene), {}, {}};
    if (space.hole().mass > 0)
        for (const ObjectDescription& object : scene.objects)
            sources.dilations.push_back(
                object.shape == Shape::disk && !object.velocity ? dilation_in_disk(space, object) : TimeDilation());
    if (!scene.space.formula || !with_orbits) return sources;
    for (const ObjectDescription& object : scene.objects)
        if (object.shape == Shape::disk && !object.velocity)
            sources.orbits.emplace_back(space, subtract(object.center, scene.space.center), object.normal, object.inner,
                                        object.outer);
        else sources.orbits.emplace_back();
    return sources;
}

std::string ranges_at_rest(const CircularOrbits& orbits, double length_unit) {
    std::string ranges;
    for (const auto& [least, greatest] : orbits.gaps())
        ranges += std::string(ranges.empty() ? "" : ", and ") + "between " + shortened(least * length_unit) + " and " +
                  shortened(greatest * length_unit);
    return ranges;
}

std::vector<std::string> remarks_on_matter(const Sources& sources, const SceneDescription& scene, double length_unit) {
    std::vector<std::string> remarks;
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        const ObjectDescription& object = scene.objects[i];
        if (object.shape != Shape::disk) continue;
        std::string remark;
        if (object.velocity) remark = remark_on_stated_velocity(*sources.space, scene, object, length_unit);
        else if (!sources.orbits.empty()) remark = remark_on_orbits(object, sources.orbits[i], length_unit);
        if (!remark.empty()) remarks.push_back(remark);
    }
    return remarks;
}

void check_disks(const Space& space, const SceneDescription& scene, double length_unit) {
    const Hole hole = space.hole();
    for (const ObjectDescription& object : scene.objects) {
        if (object.shape == Shape::disk && object.velocity) check_stated_velocity(space, scene, object, length_unit);
        if (object.shape != Shape::disk || object.velocity || hole.mass == 0) continue;
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

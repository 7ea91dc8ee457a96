#include "media/agreement.h"

#include "error.h"
#include "scene/value.h"

#include <algorithm>

namespace kagero {
namespace {

/// Returns point i of a sequence in [0, 1) that is evenly spread (Weyl's sequence of `step`).
double weyl_point(std::size_t i, double step) {
    const double value = (double(i) + 0.5) * step;
    return value - std::floor(value);
}

/// Returns points that are spread evenly over a sphere.
std::vector<SurfacePoint> points_on_sphere(const MediumBoundary& boundary, std::size_t count) {
    std::vector<SurfacePoint> points;
    for (std::size_t i = 0; i < count; ++i) {
        const double height = 2 * (double(i) + 0.5) / double(count) - 1, width = std::sqrt(1 - height * height),
                     angle = 2.39996 * double(i);
        const Double3 outward{width * std::cos(angle), width * std::sin(angle), height};
        points.push_back({&boundary, no_triangle, add(boundary.center, scaled(outward, boundary.radius)), outward});
    }
    return points;
}

/// Returns points that are spread evenly over the area of a mesh, away from the edges of its triangles.
std::vector<SurfacePoint> points_on_mesh(const MediumBoundary& boundary, std::size_t count) {
    const TriangleMesh& mesh = *boundary.mesh;
    const auto corner = [&](std::size_t triangle, std::size_t k) {
        return vertex(mesh, mesh.triangles[3 * triangle + k]);
    };
    const auto doubled_area_vector = [&](std::size_t triangle) {
        return cross(subtract(corner(triangle, 1), corner(triangle, 0)),
                     subtract(corner(triangle, 2), corner(triangle, 0)));
    };
    std::vector<double> area_up_to;
    double area = 0;
    for (std::size_t triangle = 0; triangle < mesh.triangles.size() / 3; ++triangle)
        area_up_to.push_back(area += length(doubled_area_vector(triangle)));
    std::vector<SurfacePoint> points;
    for (std::size_t i = 0; i < count; ++i) {
        const double target = area * (double(i) + 0.5) / double(count);
        const auto found = std::lower_bound(area_up_to.begin(), area_up_to.end(), target);
        const auto triangle = std::min(std::size_t(found - area_up_to.begin()), area_up_to.size() - 1);
        double u = 0.05 + 0.85 * weyl_point(i, 0.7548776662466927), v = 0.05 + 0.85 * weyl_point(i, 0.5698402909980532);
        if (u + v > 0.95) {
            u = 0.95 - u;
            v = 0.95 - v;
        }
        u = std::max(u, 0.02);
        v = std::max(v, 0.02);
        const Double3 position = add(add(scaled(corner(triangle, 0), 1 - u - v), scaled(corner(triangle, 1), u)),
                                     scaled(corner(triangle, 2), v));
        points.push_back({&boundary, static_cast<std::uint32_t>(triangle), position,
                          scaled(unit(doubled_area_vector(triangle)), boundary.outward_sign)});
    }
    return points;
}

/// Returns directions into one side of a surface, as straight rays from a point on it.
std::vector<StraightRay> rays_into(const SurfacePoint& point, bool inside) {
    constexpr int directions = 24;
    constexpr double least_cosine = 0.15;
    const Double3 axis = scaled(point.outward, inside ? -1 : 1);
    std::vector<StraightRay> rays;
    for (int i = 0; i < directions; ++i) {
        const Double3 direction = spread_direction(i, directions);
        if (dot(direction, axis) > least_cosine) rays.push_back({point.position, direction});
    }
    return rays;
}

/// The key of an object that names a medium, with its value.
struct MediumKey {
    std::string text;  ///< "object.ball.interior = "glass"".
    std::string name;  ///< "object.ball.interior".
    FileLocation location;
};

MediumKey key_of(const SceneDescription& scene, const MediumBoundary& boundary, bool interior) {
    const ObjectDescription& object = scene.objects[boundary.object];
    const std::string name = "object." + object.name + (interior ? ".interior" : ".exterior");
    return {name + " = " + to_toml(name_of_medium(scene, interior ? boundary.interior : boundary.exterior)), name,
            interior ? object.interior_location : object.exterior_location};
}

/// Throws InputError for a side of a boundary whose medium differs from that in front of the next boundary.
[[noreturn]] void refuse_disagreement(const SceneDescription& scene, const SurfacePoint& point, bool inside,
                                      const FirstBoundary& found, double unit) {
    const MediumKey stated = key_of(scene, *point.boundary, inside);
    const Double3 position = scaled(add(point.position, scene.space.center), unit);
    const std::string where =
        std::string(inside ? "just inside" : "just outside") + " the object at " + to_toml(position);
    if (!found.boundary) {
        const std::string remedy = inside ? "reverse the triangles of this part of the mesh"
                                          : "change " + stated.name + ", or enclose this region in a boundary";
        throw InputError(stated.location, stated.text + ", but a straight ray from " + where +
                                              " crosses no boundary, so that the medium there is \"space\"; " + remedy);
    }
    const MediumKey other = key_of(scene, *found.boundary, found.from_inside);
    const bool is_own = found.boundary == point.boundary;
    const std::string remedy =
        is_own ? "the normals of all parts of a mesh must point to its exterior, or all to its interior, so reverse "
                 "the triangles of some parts"
               : "both keys name the medium of the region between the objects, so change " + stated.name + " or " +
                     other.name;
    throw InputError(stated.location,
                     stated.text + ", but a straight ray from " + where + " next crosses " +
                         (is_own ? "the same object" : "object." + scene.objects[found.boundary->object].name) +
                         " from " + (found.from_inside ? "inside" : "outside") + ", where " + other.text + "; " +
                         remedy);
}

/// Checks the medium on one side of a boundary at one point.
void check_side(const SceneDescription& scene, const Boundaries& boundaries, const SurfacePoint& point, bool inside,
                double unit) {
    constexpr int rays_per_side = 2;
    const std::uint32_t stated = inside ? point.boundary->interior : point.boundary->exterior;
    int certain = 0;
    for (const StraightRay& ray : rays_into(point, inside)) {
        const auto found = boundaries.cast(ray, &point);
        if (!found) continue;
        // The region inside a boundary has a boundary in every direction.
        const bool agrees = found->medium == stated && (found->boundary || !inside);
        if (!agrees) refuse_disagreement(scene, point, inside, *found, unit);
        if (++certain == rays_per_side) return;
    }
}

}  // namespace

bool check_agreement(const SceneDescription& scene, const Boundaries& boundaries, double unit) {
    // The number of casts grows with the square of the number of boundaries.
    constexpr std::size_t least_points = 8, greatest_points = 64, points_of_scene = 65536;
    const std::size_t count = std::clamp(points_of_scene / boundaries.all().size(), least_points, greatest_points);
    bool has_contacts = false;
    for (const MediumBoundary& boundary : boundaries.all())
        for (const SurfacePoint& point :
             boundary.mesh ? points_on_mesh(boundary, count) : points_on_sphere(boundary, count)) {
            if (boundaries.touch(point)) {
                has_contacts = true;
                continue;
            }
            for (const bool inside : {false, true}) check_side(scene, boundaries, point, inside, unit);
        }
    return has_contacts;
}

}  // namespace kagero

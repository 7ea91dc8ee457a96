#include "geometry/clearance/bundle_part.h"

#include "geometry/clearance/point_query.h"

#include <algorithm>

namespace kagero {
namespace {

/// Returns the distance from q to the line segment from a to b.
double distance_to_segment(const Double3& q, const Double3& a, const Double3& b) {
    const Double3 along = subtract(b, a), from_a = subtract(q, a);
    const double square = dot(along, along);
    const double t = square > 0 ? std::clamp(dot(from_a, along) / square, 0.0, 1.0) : 0;
    return length(subtract(from_a, scaled(along, t)));
}

/// State of the test of a part of a bundle against triangles.
struct PartTest {
    static constexpr int max_triangles = 64;  ///< If more triangles are near the part, it is divided.

    /// A tube around the middle ray.
    struct Tube {
        Double3 begin, middle, end;
        double radius;

        /// Returns the distance of a point from the axis.
        double distance(const Double3& q) const {
            return std::min(distance_to_segment(q, begin, middle), distance_to_segment(q, middle, end));
        }
        /// Returns the radius of a ball around the middle that contains the tube.
        double ball_radius() const {
            return std::max(length(subtract(begin, middle)), length(subtract(end, middle))) + radius;
        }
    };

    const Geometry* geometry;
    const BundlePart* part;
    std::optional<Face> ignored;
    std::array<Tube, 2> tubes;  ///< Both contain the part.
    double ball_radius;         ///< A ball of this radius around the middle contains the part.
    int triangles = 0;
    bool is_clear = true;

    PartTest(const Geometry& scene, const BundlePart& tested, const std::optional<Face>& face)
        : geometry(&scene), part(&tested), ignored(face) {
        const auto& [begin, middle, end] = tested.slices;
        const auto extended = [&](const Double3& q) {
            const Double3 offset = subtract(q, tested.slices[1][0]);
            const double distance = length(offset);
            return distance > 0 ? add(q, scaled(offset, tested.along / distance)) : q;
        };
        tubes = {Tube{begin[0], middle[0], end[0], tested.radius + tested.bend},
                 Tube{extended(begin[0]), middle[0], extended(end[0]), tested.across + tested.bend}};
        ball_radius = std::min(tubes[0].ball_radius(), tubes[1].ball_radius());
    }
    const Double3& middle() const { return part->slices[1][0]; }
    /// Returns true if the part lies on one side of a plane. `plane` contains n and d of the plane n·x = d.
    bool is_beside_plane(const double* plane) const {
        constexpr double margin = 0.25;
        const Double3 normal{plane[0], plane[1], plane[2]};
        double least = std::numeric_limits<double>::infinity(), greatest = -least, range = 0;
        for (const BundleSlice& slice : part->slices) {
            double lower = std::numeric_limits<double>::infinity(), upper = -lower;
            for (const Double3& q : slice) {
                const double height = dot(normal, q) - plane[3];
                lower = std::min(lower, height);
                upper = std::max(upper, height);
            }
            least = std::min(least, lower);
            greatest = std::max(greatest, upper);
            range = std::max(range, upper - lower);
        }
        return std::max(least, -greatest) > margin * range + part->bend * length(normal);
    }
    /// Returns true if a triangle with these corners is outside the part.
    bool is_outside(const Double3& a, const Double3& b, const Double3& c) const {
        const Double3 center = scaled(add(a, add(b, c)), 1.0 / 3);
        const double radius =
            std::max({length(subtract(a, center)), length(subtract(b, center)), length(subtract(c, center))});
        return std::any_of(tubes.begin(), tubes.end(),
                           [&](const Tube& tube) { return tube.distance(center) > radius + tube.radius; }) ||
               length(subtract(middle(), closest_point(middle(), a, b, c))) > ball_radius;
    }
    /// Returns true if a sphere is outside a tube, or contains it.
    bool misses_sphere(const Double3& center, double radius) const {
        return std::any_of(tubes.begin(), tubes.end(), [&](const Tube& tube) {
            double farthest = 0;
            for (const Double3& q : {tube.begin, tube.middle, tube.end})
                farthest = std::max(farthest, length(subtract(q, center)));
            return tube.distance(center) > radius + tube.radius || farthest + tube.radius < radius;
        });
    }
};

/// Callback of a point query: tests one triangle. Returns true, with a search radius of 0, if the part is not clear.
bool test_triangle(RTCPointQueryFunctionArguments* arguments) {
    auto& test = *static_cast<PartTest*>(arguments->userPtr);
    const Surface& surface = test.geometry->surfaces[arguments->geomID];
    if (surface.kind != Surface::Kind::triangles ||
        (test.ignored && test.ignored->contains(arguments->geomID, arguments->primID)))
        return false;
    const std::uint32_t* index = surface.triangles + 3 * std::size_t{arguments->primID};
    const auto corner = [&](int k) {
        const double* v = surface.vertices + 3 * std::size_t{index[k]};
        return Double3{v[0], v[1], v[2]};
    };
    if (++test.triangles <= PartTest::max_triangles &&
        (test.is_beside_plane(surface.planes + 4 * std::size_t{arguments->primID}) ||
         test.is_outside(corner(0), corner(1), corner(2))))
        return false;
    test.is_clear = false;
    arguments->query->radius = 0;
    return true;
}

/// Returns true if no sphere intersects the part.
bool is_clear_of_spheres(const PartTest& test) {
    const Geometry& geometry = *test.geometry;
    for (std::uint32_t i = 0; geometry.has_spheres && i < geometry.surface_count; ++i) {
        const Surface& surface = geometry.surfaces[i];
        if (surface.kind != Surface::Kind::sphere || (test.ignored && test.ignored->contains(i, 0))) continue;
        const Double3 center{surface.center[0], surface.center[1], surface.center[2]};
        if (!test.misses_sphere(center, surface.radius)) return false;
    }
    return true;
}

}  // namespace

bool is_clear(const Geometry& geometry, const BundlePart& part, const std::optional<Face>& ignored) {
    PartTest test(geometry, part, ignored);
    if (!is_clear_of_spheres(test)) return false;
    query_around(geometry, static_cast<RTCScene>(geometry.embree_scene), {1, 1, 1}, test.middle(), test.ball_radius,
                 test_triangle, &test);
    return test.is_clear;
}

}  // namespace kagero

#include "scene/clearance.h"

#include <rtcore.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

namespace kagero {

namespace {

Double3 stretched_by(const Double3& stretch, const Double3& q) {
    return {stretch[0] * q[0], stretch[1] * q[1], stretch[2] * q[2]};
}

/// C. Ericson, Real-Time Collision Detection (2005), 5.1.5: the region of the triangle that q projects to decides.
Double3 closest_point(const Double3& q, const Double3& a, const Double3& b, const Double3& c) {
    const Double3 ab = subtract(b, a), ac = subtract(c, a), aq = subtract(q, a);
    const double d1 = dot(ab, aq), d2 = dot(ac, aq);
    if (d1 <= 0 && d2 <= 0) return a;
    const Double3 bq = subtract(q, b);
    const double d3 = dot(ab, bq), d4 = dot(ac, bq);
    if (d3 >= 0 && d4 <= d3) return b;
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return add(a, scaled(ab, d1 / (d1 - d3)));
    const Double3 cq = subtract(q, c);
    const double d5 = dot(ab, cq), d6 = dot(ac, cq);
    if (d6 >= 0 && d5 <= d6) return c;
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return add(a, scaled(ac, d2 / (d2 - d6)));
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 >= d3 && d5 >= d6) return add(b, scaled(subtract(c, b), (d4 - d3) / ((d4 - d3) + (d5 - d6))));
    return add(a, add(scaled(ab, vb / (va + vb + vc)), scaled(ac, vc / (va + vb + vc))));
}

/// From a point of stretched space.
struct Query {
    const Geometry* geometry;
    Double3 stretch, q;
    double nearest;

    Double3 corner(const Surface& surface, std::uint32_t index) const {
        const double* v = surface.vertices + 3 * std::size_t{index};
        return stretched_by(stretch, {v[0], v[1], v[2]});
    }
};

/// Embree's search radius in its own units, rounded up.
float search_radius(const Geometry& geometry, double distance) {
    const auto radius = static_cast<float>(distance * geometry.scale);
    return std::nextafter(radius, std::numeric_limits<float>::infinity());
}

bool visit(RTCPointQueryFunctionArguments* arguments) {
    auto& query = *static_cast<Query*>(arguments->userPtr);
    const Surface& surface = query.geometry->surfaces[arguments->geomID];
    if (surface.kind != Surface::Kind::triangles) return false;
    const std::uint32_t* index = surface.triangles + 3 * std::size_t{arguments->primID};
    const Double3 point = closest_point(query.q, query.corner(surface, index[0]), query.corner(surface, index[1]), query.corner(surface, index[2]));
    const Double3 way = subtract(query.q, point);
    const double distance = std::sqrt(dot(way, way));
    if (distance >= query.nearest) return false;
    query.nearest = distance;
    arguments->query->radius = search_radius(*query.geometry, distance);
    return true;
}

/// Embree's point queries pass over SPHERE_POINT, and a scene has few spheres. Nothing is nearer in stretched space than it is here.
double distance_to_spheres(const Geometry& geometry, const Double3& q, double limit) {
    for (std::uint32_t i = 0; i < geometry.surface_count; ++i) {
        const Surface& surface = geometry.surfaces[i];
        if (surface.kind != Surface::Kind::sphere) continue;
        const Double3 from_center{q[0] - surface.center[0], q[1] - surface.center[1], q[2] - surface.center[2]};
        limit = std::min(limit, std::abs(length(from_center) - surface.radius));
    }
    return limit;
}

/// The same in stretched space, from the point that is q here; not greater than `limit`.
double stretched_distance(const Geometry& geometry, RTCScene scene, const Double3& stretch, const Double3& q, double limit) {
    Query query{&geometry, stretch, stretched_by(stretch, q), distance_to_spheres(geometry, q, limit)};
    const auto coordinate = [&](std::size_t k) { return static_cast<float>((q[k] - geometry.shift[k]) * geometry.scale * stretch[k]); };
    RTCPointQuery point{};
    point.x = coordinate(0), point.y = coordinate(1), point.z = coordinate(2);
    point.radius = search_radius(geometry, query.nearest);
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene, &point, &context, visit, &query);
    return query.nearest;
}

/// Lower bounds for the centres of one row of cells along x. Distance changes by at most the way gone, so each cell limits the next one's
/// search.
void fill_row(const Geometry& geometry, RTCScene scene, const ClearanceGrid& grid, std::uint32_t y, std::uint32_t z, float* row) {
    // Of Embree's boxes, whose coordinates are of order one, 2^-18; and of what kernels make of these numbers in float.
    const double float_error = 5e-6 / geometry.scale;
    const Double3 stretch{grid.stretch[0], grid.stretch[1], grid.stretch[2]};
    double limit = std::numeric_limits<double>::infinity();
    for (std::uint32_t x = 0; x < grid.cells[0]; ++x) {
        const Double3 center{(grid.origin[0] + (x + 0.5) * grid.cell) / stretch[0], (grid.origin[1] + (y + 0.5) * grid.cell) / stretch[1],
                             (grid.origin[2] + (z + 0.5) * grid.cell) / stretch[2]};
        const double distance = stretched_distance(geometry, scene, stretch, center, limit);
        limit = distance + grid.cell + float_error;
        const double bound = std::max(0.0, distance - float_error);
        row[x] = bound > 0 ? std::nextafter(static_cast<float>(bound), 0.0f) : 0.0f;
    }
}

}  // namespace

double distance_to_surfaces(const Geometry& geometry, const Double3& q, double limit) {
    return stretched_distance(geometry, static_cast<RTCScene>(geometry.embree_scene), {1, 1, 1}, q, limit);
}

Double3 clearance_stretch(const Bounds& bounds) {
    constexpr double most = 32, share = 0.5;
    const Double3 size = subtract(bounds.upper, bounds.lower);
    const double longest = std::max({size[0], size[1], size[2]});
    Double3 stretch;
    for (std::size_t i = 0; i < 3; ++i) stretch[i] = size[i] * most > share * longest ? std::max(1.0, share * longest / size[i]) : most;
    return stretch;
}

Clearance build_clearance(const Geometry& geometry, void* stretched, const Double3& stretch, const Bounds& bounds, std::uint32_t cells) {
    Clearance clearance;
    ClearanceGrid& grid = clearance.grid;
    const Double3 lower = stretched_by(stretch, bounds.lower), upper = stretched_by(stretch, bounds.upper), size = subtract(upper, lower);
    const double margin = std::max({size[0], size[1], size[2]}) / 1024;
    grid.cell = (std::max({size[0], size[1], size[2]}) + 2 * margin) / cells;
    for (std::size_t i = 0; i < 3; ++i) {
        const double needed = std::ceil((size[i] + 2 * margin) / grid.cell - 1e-9);
        grid.cells[i] = std::max(1u, static_cast<std::uint32_t>(needed));
        grid.origin[i] = 0.5 * (lower[i] + upper[i]) - 0.5 * grid.cells[i] * grid.cell;
        grid.stretch[i] = stretch[i];
    }
    clearance.distance.resize(std::size_t{grid.cells[0]} * grid.cells[1] * grid.cells[2]);
    tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, grid.cells[1] * grid.cells[2]), [&](const auto& rows) {
        for (std::uint32_t row = rows.begin(); row != rows.end(); ++row) {
            fill_row(geometry, static_cast<RTCScene>(stretched), grid, row % grid.cells[1], row / grid.cells[1],
                     &clearance.distance[std::size_t{row} * grid.cells[0]]);
        }
    });
    grid.distance = clearance.distance.data();
    return clearance;
}

}  // namespace kagero

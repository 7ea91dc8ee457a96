#include "scene/clearance.h"

#include <rtcore.h>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

namespace kagero {

namespace {

Double3 corner(const Surface& surface, std::uint32_t index) {
    const double* v = surface.vertices + 3 * std::size_t{index};
    return {v[0], v[1], v[2]};
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

struct Query {
    const Geometry* geometry;
    Double3 q;
    double nearest;
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
    const Double3 point = closest_point(query.q, corner(surface, index[0]), corner(surface, index[1]), corner(surface, index[2]));
    const Double3 way = subtract(query.q, point);
    const double distance = std::sqrt(dot(way, way));
    if (distance >= query.nearest) return false;
    query.nearest = distance;
    arguments->query->radius = search_radius(*query.geometry, distance);
    return true;
}

/// Embree's point queries pass over SPHERE_POINT, and a scene has few spheres.
double distance_to_spheres(const Geometry& geometry, const Double3& q, double limit) {
    for (std::uint32_t i = 0; i < geometry.surface_count; ++i) {
        const Surface& surface = geometry.surfaces[i];
        if (surface.kind != Surface::Kind::sphere) continue;
        const Double3 from_center{q[0] - surface.center[0], q[1] - surface.center[1], q[2] - surface.center[2]};
        limit = std::min(limit, std::abs(length(from_center) - surface.radius));
    }
    return limit;
}

/// Lower bounds for one row of cells along x. Distance changes by at most the way gone, so each cell limits the next one's
/// search.
void fill_row(const Geometry& geometry, const ClearanceGrid& grid, std::uint32_t y, std::uint32_t z, float* row) {
    const double half_diagonal = 0.5 * std::sqrt(3.0) * grid.cell;
    const double float_error = 4e-6 / geometry.scale;  // of Embree's boxes, whose coordinates are of order one: 2^-18
    double limit = std::numeric_limits<double>::infinity();
    for (std::uint32_t x = 0; x < grid.cells[0]; ++x) {
        const Double3 center{grid.origin[0] + (x + 0.5) * grid.cell, grid.origin[1] + (y + 0.5) * grid.cell,
                             grid.origin[2] + (z + 0.5) * grid.cell};
        const double distance = distance_to_surfaces(geometry, center, limit);
        limit = distance + grid.cell + float_error;
        const double bound = std::max(0.0, distance - half_diagonal - float_error);
        row[x] = bound > 0 ? std::nextafter(static_cast<float>(bound), 0.0f) : 0.0f;
    }
}

}  // namespace

double distance_to_surfaces(const Geometry& geometry, const Double3& q, double limit) {
    Query query{&geometry, q, distance_to_spheres(geometry, q, limit)};
    RTCPointQuery point{};
    point.x = static_cast<float>((q[0] - geometry.shift[0]) * geometry.scale);
    point.y = static_cast<float>((q[1] - geometry.shift[1]) * geometry.scale);
    point.z = static_cast<float>((q[2] - geometry.shift[2]) * geometry.scale);
    point.radius = search_radius(geometry, query.nearest);
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(static_cast<RTCScene>(geometry.embree_scene), &point, &context, visit, &query);
    return query.nearest;
}

Clearance build_clearance(const Geometry& geometry, const Bounds& bounds, std::uint32_t cells) {
    Clearance clearance;
    ClearanceGrid& grid = clearance.grid;
    const Double3 size = subtract(bounds.upper, bounds.lower);
    const double margin = std::max({size[0], size[1], size[2]}) / 1024;
    grid.cell = (std::max({size[0], size[1], size[2]}) + 2 * margin) / cells;
    for (std::size_t i = 0; i < 3; ++i) {
        const double needed = std::ceil((size[i] + 2 * margin) / grid.cell - 1e-9);
        grid.cells[i] = std::max(1u, static_cast<std::uint32_t>(needed));
        grid.origin[i] = 0.5 * (bounds.lower[i] + bounds.upper[i]) - 0.5 * grid.cells[i] * grid.cell;
    }
    clearance.distance.resize(std::size_t{grid.cells[0]} * grid.cells[1] * grid.cells[2]);
    tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, grid.cells[1] * grid.cells[2]), [&](const auto& rows) {
        for (std::uint32_t row = rows.begin(); row != rows.end(); ++row) {
            fill_row(geometry, grid, row % grid.cells[1], row / grid.cells[1],
                     &clearance.distance[std::size_t{row} * grid.cells[0]]);
        }
    });
    grid.distance = clearance.distance.data();
    return clearance;
}

}  // namespace kagero

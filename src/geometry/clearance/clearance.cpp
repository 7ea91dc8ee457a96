#include "geometry/clearance/clearance.h"

#include "geometry/clearance/point_query.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

namespace kagero {

// Algorithm of C. Ericson, Real-Time Collision Detection (2005), section 5.1.5. It finds the corner, edge or interior
// of the triangle that contains the closest point.
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

namespace {

/// Returns q with its components multiplied by those of `stretch`.
Double3 stretched_by(const Double3& stretch, const Double3& q) {
    return {stretch[0] * q[0], stretch[1] * q[1], stretch[2] * q[2]};
}

/// State of the search for the triangle nearest to a point q. All coordinates and distances are in stretched space, in
/// which coordinates are multiplied by `stretch`.
struct NearestSearch {
    const Geometry* geometry;
    Double3 stretch, q;
    double nearest;  ///< Least distance found so far.

    /// Returns true if the plane of a triangle is at most `nearest` away from q; the triangle cannot be closer than its
    /// plane. `plane` contains n and d of the plane n·x = d in unstretched space.
    bool may_be_nearest(const double* plane) const {
        const Double3 normal{plane[0] / stretch[0], plane[1] / stretch[1], plane[2] / stretch[2]};
        const double height = dot(normal, q) - plane[3];
        return !(height * height > nearest * nearest * dot(normal, normal));  // true if the normal is zero or NaN
    }

    /// Returns the coordinates of a vertex.
    Double3 corner(const Surface& surface, std::uint32_t index) const {
        const double* v = surface.vertices + 3 * std::size_t{index};
        return stretched_by(stretch, {v[0], v[1], v[2]});
    }
};

/// Callback of a point query: updates the search with one triangle. Returns true if the search radius has decreased.
bool update_nearest(RTCPointQueryFunctionArguments* arguments) {
    auto& search = *static_cast<NearestSearch*>(arguments->userPtr);
    const Surface& surface = search.geometry->surfaces[arguments->geomID];
    if (surface.kind != Surface::Kind::triangles ||
        !search.may_be_nearest(surface.planes + 4 * std::size_t{arguments->primID}))
        return false;
    const std::uint32_t* index = surface.triangles + 3 * std::size_t{arguments->primID};
    const Double3 point = closest_point(search.q, search.corner(surface, index[0]), search.corner(surface, index[1]),
                                        search.corner(surface, index[2]));
    const Double3 offset = subtract(search.q, point);
    const double distance = std::sqrt(dot(offset, offset));
    if (distance >= search.nearest) return false;
    search.nearest = distance;
    arguments->query->radius = search_radius(*search.geometry, distance);
    return true;
}

/// Returns the distance from q to the nearest sphere, or `limit` if that is smaller. The search in Embree's scene
/// ignores spheres, so all of them are tested; scenes have few. The distance is a lower bound on the distance in
/// stretched space, because all factors of `stretch` are at least 1.
double distance_to_spheres(const Geometry& geometry, const Double3& q, double limit) {
    if (!geometry.has_spheres) return limit;
    for (std::uint32_t i = 0; i < geometry.surface_count; ++i) {
        const Surface& surface = geometry.surfaces[i];
        if (surface.kind != Surface::Kind::sphere) continue;
        const Double3 from_center{q[0] - surface.center[0], q[1] - surface.center[1], q[2] - surface.center[2]};
        limit = std::min(limit, std::abs(length(from_center) - surface.radius));
    }
    return limit;
}

/// Returns a lower bound, in stretched space, on the distance to the nearest surface, or `limit` if that is smaller. q
/// is given in unstretched coordinates. The bound is exact for triangles.
double stretched_distance(const Geometry& geometry, RTCScene scene, const Double3& stretch, const Double3& q,
                          double limit) {
    NearestSearch search{&geometry, stretch, stretched_by(stretch, q), distance_to_spheres(geometry, q, limit)};
    query_around(geometry, scene, stretch, q, search.nearest, update_nearest, &search);
    return search.nearest;
}

/// Collects boxes that together contain all parts of surfaces in one cell of the grid.
struct ContentCollector {
    const Geometry* geometry;
    Double3 lower_corner, edges;  ///< Lower corner and edge lengths of the cell.
    std::array<std::uint32_t, 3> cell;  ///< Indices of the cell along x, y and z.
    std::vector<GridBox>* content;

    /// Adds the intersection of `bounds` and the cell, if they intersect. After eight boxes, further boxes are merged
    /// with the last one.
    void add(const Bounds& bounds) const {
        constexpr std::size_t max_boxes = 8;
        GridBox box;
        for (std::size_t k = 0; k < 3; ++k) {
            const double lower = (bounds.lower[k] - lower_corner[k]) / edges[k],
                         upper = (bounds.upper[k] - lower_corner[k]) / edges[k];
            if (lower > 1 || upper < 0) return;
            box.lower[k] = float(cell[k] + std::max(lower, 0.0));
            box.upper[k] = float(cell[k] + std::min(upper, 1.0));
        }
        if (content->size() == max_boxes) {
            GridBox& last = content->back();
            for (std::size_t k = 0; k < 3; ++k) {
                last.lower[k] = std::min(last.lower[k], box.lower[k]);
                last.upper[k] = std::max(last.upper[k], box.upper[k]);
            }
        } else content->push_back(box);
    }
};

/// Callback of a point query: adds the bounding box of one triangle. Returns false, because the radius is unchanged.
bool collect_triangle(RTCPointQueryFunctionArguments* arguments) {
    const auto& collector = *static_cast<const ContentCollector*>(arguments->userPtr);
    const Surface& surface = collector.geometry->surfaces[arguments->geomID];
    if (surface.kind != Surface::Kind::triangles) return false;
    Bounds bounds;
    for (std::size_t k = 0; k < 3; ++k) {
        const double* v = surface.vertices + 3 * std::size_t{surface.triangles[3 * std::size_t{arguments->primID} + k]};
        bounds.extend({v[0], v[1], v[2]});
    }
    collector.add(bounds);
    return false;
}

/// Returns boxes that together contain all parts of surfaces in the cell with the given centre. No point of the cell is
/// farther than `radius` from the centre in stretched space.
std::vector<GridBox> content_of(const Geometry& geometry, RTCScene scene, const Double3& stretch,
                                const ClearanceGrid& grid, const std::array<std::uint32_t, 3>& cell,
                                const Double3& center, double radius) {
    std::vector<GridBox> content;
    const Double3 edges{grid.cell[0], grid.cell[1], grid.cell[2]};
    ContentCollector collector{&geometry, subtract(center, scaled(edges, 0.5)), edges, cell, &content};
    for (std::uint32_t i = 0; i < geometry.surface_count; ++i) {
        const Surface& surface = geometry.surfaces[i];
        if (surface.kind != Surface::Kind::sphere) continue;
        const Double3 middle{surface.center[0], surface.center[1], surface.center[2]};
        // This distance is a lower bound on the distance in stretched space.
        if (std::abs(length(subtract(center, middle)) - surface.radius) > radius) continue;
        Bounds bounds;
        bounds.extend(middle, surface.radius);
        collector.add(bounds);
    }
    query_around(geometry, scene, stretch, center, radius, collect_triangle, &collector);
    return content;
}

/// Computes the CellClearance of one row of cells along x. From one cell to the next, the distance to the nearest
/// surface increases by at most one cell edge. This bound limits the search for the next cell.
void measure_row(const Geometry& geometry, RTCScene scene, const Double3& stretch, const ClearanceGrid& grid,
                 std::uint32_t y, std::uint32_t z, CellClearance* row) {
    // Bound on single-precision errors: 5e-6 in Embree's coordinates, which are of order one. The errors of Embree's
    // bounding boxes are at most 2^-18; the remaining 1.2e-6 covers the kernels, which use single precision.
    const double float_error = 5e-6 / geometry.scale, edge = stretch[0] * grid.cell[0];
    const double half_diagonal = 0.8661 * edge;  // √3/2, rounded up
    double limit = std::numeric_limits<double>::infinity();
    for (std::uint32_t x = 0; x < grid.cells[0]; ++x) {
        const Double3 center{grid.origin[0] + (x + 0.5) * grid.cell[0], grid.origin[1] + (y + 0.5) * grid.cell[1],
                             grid.origin[2] + (z + 0.5) * grid.cell[2]};
        const double distance = stretched_distance(geometry, scene, stretch, center, limit);
        limit = distance + edge + float_error;
        row[x].distance = static_cast<float>(std::max(0.0, distance - float_error) / edge);
        if (distance - float_error < half_diagonal)
            row[x].content = content_of(geometry, scene, stretch, grid, {x, y, z}, center, half_diagonal + float_error);
    }
}

}  // namespace

double distance_to_surfaces(const Geometry& geometry, const Double3& q, double limit) {
    return stretched_distance(geometry, static_cast<RTCScene>(geometry.embree_scene), {1, 1, 1}, q, limit);
}

Double3 clearance_stretch(const Bounds& bounds) {
    constexpr double max_stretch = 32, least_ratio = 0.5;  // ratio of a stretched axis to the longest one
    const Double3 size = subtract(bounds.upper, bounds.lower);
    const double longest = std::max({size[0], size[1], size[2]});
    Double3 stretch;
    for (std::size_t i = 0; i < 3; ++i)
        stretch[i] = size[i] * max_stretch > least_ratio * longest ? std::max(1.0, least_ratio * longest / size[i])
                                                                   : max_stretch;
    return stretch;
}

Clearance build_clearance(const Geometry& geometry, void* stretched_scene, const Double3& stretch, const Bounds& bounds,
                          std::uint32_t cells) {
    Clearance clearance;
    ClearanceGrid& grid = clearance.grid;
    const Double3 lower = stretched_by(stretch, bounds.lower), upper = stretched_by(stretch, bounds.upper),
                  size = subtract(upper, lower);
    const double margin = std::max({size[0], size[1], size[2]}) / 1024;
    const double edge = (std::max({size[0], size[1], size[2]}) + 2 * margin) / cells;
    for (std::size_t i = 0; i < 3; ++i) {
        const double needed = std::ceil((size[i] + 2 * margin) / edge - 1e-9);
        grid.cells[i] = std::max(1u, static_cast<std::uint32_t>(needed));
        grid.cell[i] = edge / stretch[i];
        grid.origin[i] = 0.5 * (bounds.lower[i] + bounds.upper[i] - grid.cells[i] * grid.cell[i]);
    }
    std::vector<CellClearance> measured(std::size_t{grid.cells[0]} * grid.cells[1] * grid.cells[2]);
    tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, grid.cells[1] * grid.cells[2]), [&](const auto& rows) {
        for (std::uint32_t row = rows.begin(); row != rows.end(); ++row) {
            measure_row(geometry, static_cast<RTCScene>(stretched_scene), stretch, grid, row % grid.cells[1],
                        row / grid.cells[1], &measured[std::size_t{row} * grid.cells[0]]);
        }
    });
    clearance.boxes = grow_clear_boxes({grid.cells[0], grid.cells[1], grid.cells[2]}, measured);
    grid.box_index = clearance.boxes.box_index.data();
    grid.boxes = clearance.boxes.boxes.data();
    return clearance;
}

}  // namespace kagero

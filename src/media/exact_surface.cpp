#include "media/exact_surface.h"

#include <algorithm>

namespace kagero {
namespace {

/// Returns the greatest absolute coordinate of the points in a box.
double greatest_coordinate(const Bounds& bounds) {
    double greatest = 0;
    for (std::size_t i = 0; i < 3; ++i)
        greatest = std::max({greatest, std::abs(bounds.lower[i]), std::abs(bounds.upper[i])});
    return greatest;
}

/// Returns true if two spheres come closer to each other than `limit`, or intersect.
bool spheres_come_close(const ExactSurface& one, const ExactSurface& other, double limit) {
    const double distance = length(subtract(one.center, other.center));
    return distance < one.radius + other.radius + limit && distance > std::abs(one.radius - other.radius) - limit;
}

}  // namespace

Bounds bounds_of_surface(const ObjectDescription& description, const ObjectGeometry& geometry) {
    Bounds bounds;
    if (description.shape == Shape::sphere) bounds.extend(geometry.center, description.radius);
    for (const std::uint32_t index : geometry.mesh.triangles) bounds.extend(vertex(geometry.mesh, index));
    return bounds;
}

ExactSurface exact_surface(const ObjectDescription& description, std::uint32_t object, const ObjectGeometry& geometry) {
    ExactSurface surface;
    surface.object = object;
    if (description.shape == Shape::sphere) {
        surface.center = geometry.center;
        surface.radius = description.radius;
    } else {
        surface.mesh = &geometry.mesh;
        surface.tree = std::make_shared<const TriangleTree>(geometry.mesh);
    }
    surface.bounds = bounds_of_surface(description, geometry);
    const double greatest = greatest_coordinate(surface.bounds);
    surface.size = length(subtract(surface.bounds.upper, surface.bounds.lower));
    surface.rounding = 1e-9 * surface.size + 8 * std::numeric_limits<double>::epsilon() * greatest;
    // Rays that meet surfaces at small angles see their distance several times enlarged.
    if (description.shape == Shape::mesh)
        surface.file_rounding = 4 * double(std::numeric_limits<float>::epsilon()) * greatest;
    return surface;
}

Double3 normal_of(const TriangleMesh& mesh, std::uint32_t triangle) {
    const std::uint32_t* index = &mesh.triangles[3 * std::size_t{triangle}];
    const Double3 a = vertex(mesh, index[0]), b = vertex(mesh, index[1]), c = vertex(mesh, index[2]);
    return unit(cross(subtract(b, a), subtract(c, a)));
}

double contact_width(const ExactSurface& one, const ExactSurface& other) {
    return std::min(one.rounding, other.rounding) + one.file_rounding + other.file_rounding;
}

bool come_close(const ExactSurface& one, const ExactSurface& other, double limit) {
    if (one.tree && other.tree) return one.tree->comes_close_to(*other.tree, limit);
    if (one.tree) return one.tree->comes_close_to(other.center, other.radius, limit);
    if (other.tree) return other.tree->comes_close_to(one.center, one.radius, limit);
    return spheres_come_close(one, other, limit);
}

}  // namespace kagero

#include "geometry/shapes.h"
#include "scene/vector3.h"

#include <numbers>

namespace kagero {

namespace {

/// Appends two triangles that form a parallelogram. u and v increase from 0 to 1 along edge_u and edge_v.
void append_parallelogram(TriangleMesh& mesh, const Double3& corner, const Double3& edge_u, const Double3& edge_v) {
    const auto first_vertex = static_cast<std::uint32_t>(mesh.vertices.size() / 3);
    const Double3 corners[] = {corner, add(corner, edge_u), add(add(corner, edge_u), edge_v), add(corner, edge_v)};
    for (const Double3& point : corners) mesh.vertices.insert(mesh.vertices.end(), point.begin(), point.end());
    mesh.uv.insert(mesh.uv.end(), {0, 0, 1, 0, 1, 1, 0, 1});
    for (const std::uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) mesh.triangles.push_back(first_vertex + i);
}

}  // namespace

TriangleMesh rectangle_mesh(const ObjectDescription& object, const Double3& space_center) {
    TriangleMesh mesh;
    append_parallelogram(mesh, subtract(object.origin, space_center), object.edge_u, object.edge_v);
    return mesh;
}

TriangleMesh box_mesh(const ObjectDescription& object, const Double3& space_center) {
    TriangleMesh mesh;
    for (std::size_t face = 0; face < 6; ++face) {
        const std::size_t axis = face / 2;
        const bool positive = face % 2 == 0;
        Double3 outward{}, up{};
        outward[axis] = positive ? 1 : -1;
        up[axis == 2 ? 1 : 2] = 1;
        // A viewer inside a room looks along `outward`, and a viewer outside a box looks in the opposite direction. For
        // both, right = forward × up.
        const Double3 forward = scaled(outward, object.shape == Shape::room ? 1 : -1);
        const Double3 right = cross(forward, up);
        Double3 corner{}, edge_u{}, edge_v{};
        for (std::size_t i = 0; i < 3; ++i) {
            const bool from_max = i == axis ? positive : right[i] < 0;
            corner[i] = (from_max ? object.max[i] : object.min[i]) - space_center[i];
            edge_u[i] = right[i] * (object.max[i] - object.min[i]);
            edge_v[i] = up[i] * (object.max[i] - object.min[i]);
        }
        append_parallelogram(mesh, corner, edge_u, edge_v);
    }
    return mesh;
}

TriangleMesh disk_mesh(const ObjectDescription& object, const Double3& space_center) {
    constexpr std::uint32_t segments = 64;
    const auto [x_axis, y_axis] = axes_around(object.normal);
    const Double3 center = subtract(object.center, space_center);
    // The inner polygon is inscribed in the inner circle, and the outer polygon encloses the outer circle.
    const double radii[] = {object.inner, object.outer / std::cos(std::numbers::pi / segments) * (1 + 1e-6)};
    TriangleMesh mesh;
    for (std::uint32_t i = 0; i < segments; ++i) {
        const double angle = 2 * std::numbers::pi * i / segments;
        const Double3 outward = add(scaled(x_axis, std::cos(angle)), scaled(y_axis, std::sin(angle)));
        for (const double radius : radii) {
            const Double3 point = add(center, scaled(outward, radius));
            mesh.vertices.insert(mesh.vertices.end(), point.begin(), point.end());
        }
        const std::uint32_t inner = 2 * i, next_inner = 2 * ((i + 1) % segments);
        for (const std::uint32_t index : {inner, inner + 1, next_inner + 1, inner, next_inner + 1, next_inner})
            mesh.triangles.push_back(index);
    }
    return mesh;
}

std::vector<double> planes_of(const TriangleMesh& mesh) {
    std::vector<double> planes;
    planes.reserve(mesh.triangles.size() / 3 * 4);
    for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
        const std::uint32_t* index = &mesh.triangles[i];
        const Double3 a = vertex(mesh, index[0]);
        const Double3 n = unit(cross(subtract(vertex(mesh, index[1]), a), subtract(vertex(mesh, index[2]), a)));
        planes.insert(planes.end(), {n[0], n[1], n[2], dot(n, a)});
    }
    return planes;
}

std::array<Double3, 2> axes_around(const Double3& pole) {
    const Double3 up = unit(pole);
    Double3 zero = subtract({1, 0, 0}, scaled(up, up[0]));
    if (length(zero) < std::sqrt(std::numeric_limits<double>::epsilon())) zero = {0, 0, up[0] > 0 ? -1.0 : 1.0};
    zero = unit(zero);
    return {zero, cross(up, zero)};
}

}  // namespace kagero

#include "scene/shapes.h"
#include "scene/vector3.h"

namespace kagero {

namespace {

void append_parallelogram(TriangleMesh& mesh, const Double3& corner, const Double3& edge_u, const Double3& edge_v) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size() / 3);
    const Double3 corners[] = {corner, add(corner, edge_u), add(add(corner, edge_u), edge_v), add(corner, edge_v)};
    for (const Double3& point : corners) mesh.vertices.insert(mesh.vertices.end(), point.begin(), point.end());
    mesh.uv.insert(mesh.uv.end(), {0, 0, 1, 0, 1, 1, 0, 1});
    for (const std::uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) mesh.triangles.push_back(first + i);
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
        // Who stands inside looks along `outward`, who stands outside against it; right = forward × up.
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

}  // namespace kagero

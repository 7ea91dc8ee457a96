/// Triangle meshes of rectangles, boxes, rooms and disks; planes of triangles; axes perpendicular to a pole.
#pragma once

#include "scene/description.h"

namespace kagero {

/// Triangles in coordinates relative to `space.center`. The arrays `normals` and `uv` have entries for every vertex, or
/// they are empty.
struct TriangleMesh {
    std::vector<double> vertices;          ///< Three coordinates per vertex.
    std::vector<std::uint32_t> triangles;  ///< Three vertex indices per triangle.
    std::vector<double> normals;           ///< Unit normal of each vertex; zero if the file has no valid normal.
    std::vector<double> uv;                ///< u and v of each vertex.
};

/// Returns a rectangle as two triangles. u increases from 0 to 1 along edge_u, and v from 0 to 1 along edge_v.
TriangleMesh rectangle_mesh(const ObjectDescription& object, const Double3& space_center);

/// Returns a box or room as two triangles per face. The faces have the order px, nx, py, ny, pz, nz: triangle i belongs
/// to face i / 2. As seen from inside a room or from outside a box, u increases to the right and v upward. Upward means
/// +z, or +y on the floor and the ceiling.
TriangleMesh box_mesh(const ObjectDescription& object, const Double3& space_center);

/// Returns a ring of triangles that covers the disk between its two radii and slightly more.
TriangleMesh disk_mesh(const ObjectDescription& object, const Double3& space_center);

/// Returns four numbers nx, ny, nz, d for every triangle. The plane of the triangle is n·q = d, with n of unit length.
std::vector<double> planes_of(const TriangleMesh& mesh);

/// Returns the directions of the angles 0° and 90° around `pole`: unit vectors that form a right-handed system with the
/// pole. The direction of 0° is the projection of +x onto the plane perpendicular to the pole. If the pole is ±x, this
/// direction is ∓z, the image of +x under the shortest rotation from +z to the pole.
std::array<Double3, 2> axes_around(const Double3& pole);

/// Returns the coordinates of a vertex.
inline Double3 vertex(const TriangleMesh& mesh, std::uint32_t index) {
    const double* v = &mesh.vertices[3 * std::size_t{index}];
    return {v[0], v[1], v[2]};
}

}  // namespace kagero

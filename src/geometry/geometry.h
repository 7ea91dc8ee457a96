/// The surfaces of a scene, as an Embree scene and as data for the kernels.
#pragma once

#include "geometry/shapes.h"

#include <memory>

namespace kagero {

/// Geometry of one object, relative to `space.center`. Object i is surface i of the kernels.
struct ObjectGeometry {
    Shape shape{};
    TriangleMesh mesh;           ///< Triangles; none for a sphere.
    std::vector<double> planes;  ///< Planes of the triangles, as planes_of returns them.
    Double3 center{};            ///< Centre of a sphere or disk.
};

/// Owns the Embree scene, the double-precision vertices and the clearance grid. Immutable after construction, so any
/// number of threads may use it concurrently.
class SceneGeometry {
public:
    /// Maximum number of cells along the longest edge of the clearance grid.
    static constexpr std::uint32_t max_clearance_cells = 48;

    /// Loads the meshes, and builds the Embree scene and the clearance grid. `clearance_cells` is the number of cells
    /// along the grid's longest edge. No grid is built if it is 0, or if the scene switches culling off. Throws
    /// InputError if the data cannot be used.
    explicit SceneGeometry(const SceneDescription& scene, std::uint32_t clearance_cells = max_clearance_cells);
    ~SceneGeometry();

    /// Returns the data for the kernels, relative to `space.center`; null if the scene has no objects.
    const Geometry* kernel_view() const;
    /// Returns the objects in the order of the scene file.
    const std::vector<ObjectGeometry>& objects() const;
    /// Returns true if two points of a surface, on the given primitives, lie on the same face, so that a texture or
    /// checker may be averaged between them. On a box or room, this is one of the six faces. On a mesh, the segment
    /// between the points must be within 30° of both triangles, so that points on separate parts are excluded. Other
    /// shapes have only one face.
    bool on_same_face(std::uint32_t surface, std::uint32_t primitive, const Double3& point,
                      std::uint32_t other_primitive, const Double3& other) const;
    /// Returns remarks on objects for the user, such as the number of triangles without area; one line each.
    const std::vector<std::string>& remarks() const;
    /// Returns the distance from `space.center` to the nearest surface, or `limit` if that is smaller.
    double distance_from_center(double limit) const;
    /// Returns true if a point of a surface is at most `radius` away from `space.center`.
    bool comes_within(std::uint32_t surface, double radius) const;
    /// Returns the diagonal of the box around all objects, in scene units; 0 without objects.
    double diagonal() const;

private:
    struct Content;
    std::unique_ptr<Content> content_;
};

}  // namespace kagero

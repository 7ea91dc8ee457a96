/// A scene's surfaces as Embree geometry for the kernels.
#pragma once

#include "geometry/shapes.h"

#include <memory>

namespace kagero {

/// One object in coordinates relative to `space.center`; surface i of the kernels is object i.
struct ObjectGeometry {
    Shape shape{};
    TriangleMesh mesh;           ///< empty for a sphere
    std::vector<double> planes;  ///< of its triangles
    Double3 center{};            ///< of a sphere or disk
};

/// Owns the Embree scene, the double-precision vertices and the clearance grid. Immutable after construction, so any
/// number of threads may use it at once.
class SceneGeometry {
public:
    /// Cells along the longest edge of the clearance grid, at most.
    static constexpr std::uint32_t most_clearance_cells = 48;

    /// Loads meshes, and builds the Embree scene and a clearance grid of so many cells along its longest edge; no grid
    /// for 0 cells, or if the scene culls nothing. Throws InputError for data that cannot be used.
    explicit SceneGeometry(const SceneDescription& scene, std::uint32_t clearance_cells = most_clearance_cells);
    ~SceneGeometry();

    /// What the kernels need, in coordinates relative to `space.center`; null when the scene has no objects.
    const Geometry* kernel_view() const;
    const std::vector<ObjectGeometry>& objects() const;
    /// Whether two places, on primitives of a surface, belong together: on the same face of a box or room; on a mesh
    /// only where the way from one to the other leads along it, and not from one of its parts to another behind.
    bool on_same_face(std::uint32_t surface, std::uint32_t primitive, const Double3& point,
                      std::uint32_t other_primitive, const Double3& other) const;
    /// One line per object that the user may want to know of: degenerate triangles skipped, faces triangulated …
    const std::vector<std::string>& remarks() const;
    /// Distance from `space.center` to the nearest point of any object, not greater than `limit`.
    double nearest(double limit) const;
    /// Whether any point of a surface lies within a sphere around `space.center`.
    bool comes_within(std::uint32_t surface, double radius) const;
    /// Diagonal of the box around all objects, scene units; 0 without objects.
    double diagonal() const;

private:
    struct Content;
    std::unique_ptr<Content> content_;
};

}  // namespace kagero

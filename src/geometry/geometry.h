/// The surfaces of a scene, as an Embree scene and as data for the kernels.
#pragma once

#include "geometry/clearance/clearance.h"
#include "geometry/shapes.h"

#include <memory>
#include <optional>

namespace kagero {

/// Geometry of one object, in coordinates relative to `space.center`. Object i is surface i of the kernels.
struct ObjectGeometry {
    Shape shape{};
    TriangleMesh mesh;           ///< Triangles; none for a sphere.
    std::vector<double> planes;  ///< Planes of the triangles, as planes_of returns them.
    Double3 center{};            ///< Centre of a sphere or disk.
    std::string file_inputs{};   ///< Text that determines the mesh if it is read from a file; empty for other shapes.
    std::vector<std::string> file_remarks{};  ///< Remarks on the file of a mesh.
};

/// A spheroid around `space.center` with its axis along z, given by its semi-axes.
struct Spheroid {
    double equator, pole;
};

/// The least and greatest of √((x² + y²)/equator² + z²/pole²) on a surface: below 1 inside the spheroid.
struct SpheroidRange {
    double least, greatest;
};

/// Owns the Embree scene, the double-precision vertices and the clearance grid. Immutable after construction, so any
/// number of threads may use it concurrently.
class SceneGeometry {
public:
    /// Maximum number of cells along the longest edge of the clearance grid.
    static constexpr std::uint32_t max_clearance_cells = 48;

    /// Loads the meshes, and builds the Embree scene and the clearance grid. `clearance_cells` is the number of cells
    /// along the grid's longest edge. No grid is built if this number is 0, or if the scene switches culling off.
    /// Throws InputError if a mesh cannot be loaded or if the objects are too small. If `reflected` is given, kernels
    /// get the objects inside this spheroid reflected, y → −y (kernels/observers/charts.h). `earlier`, if not null, is
    /// the geometry of another frame. Its meshes are used again for objects that have not changed.
    explicit SceneGeometry(const SceneDescription& scene, std::uint32_t clearance_cells = max_clearance_cells,
                           const std::optional<Spheroid>& reflected = {}, const SceneGeometry* earlier = nullptr);
    ~SceneGeometry();

    /// Returns the data for the kernels, relative to `space.center`; null if the scene has no objects.
    const Geometry* kernel_view() const;
    /// Returns the objects in the order of the scene file.
    const std::vector<ObjectGeometry>& objects() const;
    /// Returns true if two points of a surface lie on the same face, so that a texture or checker may be averaged
    /// between them. A primitive is the index of the triangle that contains a point. Boxes and rooms have six faces. On
    /// a mesh, two points are on the same face if the segment between them is within 30° of the planes of both
    /// triangles; this excludes points on separate parts. Other shapes have only one face.
    bool on_same_face(std::uint32_t surface, std::uint32_t primitive, const Double3& point,
                      std::uint32_t other_primitive, const Double3& other_point) const;
    /// Returns the largest part of a surface around a triangle whose hits depend smoothly on the ray: a face of a box
    /// or room, one triangle of a mesh, or all of another shape.
    Face face_of(std::uint32_t surface, std::uint32_t primitive) const;
    /// Returns remarks on objects, such as the number of triangles without area. Each is one line of text for the user.
    const std::vector<std::string>& remarks() const;
    /// Returns the distance from `space.center` to the nearest surface, or `limit` if that is smaller.
    double distance_from_center(double limit) const;
    /// Returns true if any point of a surface is at most `radius` away from `space.center`.
    bool comes_within(std::uint32_t surface, double radius) const;
    /// Returns the range of a surface with respect to a spheroid.
    SpheroidRange range_of(std::uint32_t surface, const Spheroid& spheroid) const;
    /// Returns the diagonal of the bounding box of all objects, in the unit of the loaded scene; 0 without objects.
    double diagonal() const;

private:
    struct Content;
    std::unique_ptr<Content> content_;
};

}  // namespace kagero

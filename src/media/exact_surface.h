/// The surface of an object in double precision.
#pragma once

#include "geometry/geometry.h"
#include "media/triangle_tree.h"
#include "scene/description.h"

#include <memory>

namespace kagero {

/// A sphere or a mesh. Coordinates are relative to `space.center`, in the unit of the kernels.
struct ExactSurface {
    std::uint32_t object = 0;                  ///< Index in SceneDescription::objects.
    Double3 center{};                          ///< Centre of a sphere.
    double radius = 0;                         ///< Radius of a sphere; 0 for triangles.
    const TriangleMesh* mesh = nullptr;        ///< Triangles; null for a sphere.
    std::shared_ptr<const TriangleTree> tree;  ///< Tree of the triangles; null for a sphere.
    Bounds bounds;
    double size = 0;      ///< Diagonal of its bounding box.
    double rounding = 0;  ///< Distance from the surface below which points count as on it.
    /// Bound of the rounding of the coordinates of a mesh file, which is read in single precision; else 0.
    double file_rounding = 0;
};

/// Returns the bounding box of the surface of an object.
Bounds bounds_of_surface(const ObjectDescription& description, const ObjectGeometry& geometry);

/// Returns the surface of an object. `geometry`, which is that of the object, must outlive it.
ExactSurface exact_surface(const ObjectDescription& description, std::uint32_t object, const ObjectGeometry& geometry);

/// Returns the unit normal of a triangle abc, along (b − a) × (c − a).
Double3 normal_of(const TriangleMesh& mesh, std::uint32_t triangle);

/// Returns the distance up to which two surfaces count as touching each other.
double contact_width(const ExactSurface& one, const ExactSurface& other);

/// Returns true if two surfaces come closer to each other than `limit`. The bounding boxes of triangles decide, so it
/// may also be true if the triangles of meshes are a little farther apart.
bool come_close(const ExactSurface& one, const ExactSurface& other, double limit);

}  // namespace kagero

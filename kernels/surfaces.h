/// The surfaces of a scene as the kernels see them. Part of the binary interface (abi.h).
#pragma once

#include <cstdint>

namespace kagero {
/// Value of an index that refers to no surface.
inline constexpr std::uint32_t no_surface = ~std::uint32_t(0);

/// The surface of one object, such as a whole box or mesh. Surfaces have the order of Embree's geometry identifiers.
struct Surface {
    enum class Kind : std::uint8_t { triangles, sphere };
    Kind kind;
    const double* vertices;          ///< Three coordinates per vertex (triangles).
    const std::uint32_t* triangles;  ///< Three vertex indices per triangle.
    const double* planes;            ///< Four numbers per triangle: unit normal n and d in n·q = d.
    double center[3];                ///< Center of a sphere.
    double radius;                   ///< Radius of a sphere.
};

/// A grid that contains all surfaces. Each cell refers to a clear box; the first six boxes are the half-spaces beyond
/// the faces −x, +x, −y, +y, −z, +z of the grid.
struct ClearanceGrid {
    const float* box_index;  ///< For each cell, x fastest: index into `boxes`.
    const float* boxes;      ///< Six numbers per box: lower x, y, z and upper x, y, z, in cells from `origin`.
    std::uint32_t cells[3];
    double origin[3], cell[3];  ///< Lower corner of the first cell; edge lengths of a cell.
};

/// The surfaces of a scene. Embree uses float coordinates of order one: e = (q − shift) · scale.
struct Geometry {
    void* embree_scene;  ///< Committed RTCScene.
    double shift[3];
    double scale;
    const Surface* surfaces;
    std::uint32_t surface_count;
    bool has_spheres;
    const ClearanceGrid* clearance;  ///< Null: every segment is queried.
};

/// A ray at a surface that sends it on. The surface changes only the part of the momentum along its normal.
struct SurfaceRay {
    double q[3], p[3], pt;  ///< Position, momentum before the surface, and p_t on the side where the ray continues.
    double normal[3];       ///< Unit normal of the surface, on the side where the ray continues.
    /// True for a reflected ray: if no momentum along the normal has H = H0, H keeps its value, with the error of the
    /// integration. Otherwise, a ray at a small angle to the surface could not be reflected.
    bool may_keep_value;
};

/// The continuation of a SurfaceRay in the space of one side.
struct Continuation {
    double p[3];         ///< Momentum p' = p + α n with H = H0, where the ray moves along the normal.
    double velocity[3];  ///< ∂H/∂p'.
    double curvature;    ///< n·(∂²H/∂p'²) n.
    bool exists;         ///< False if there is no such momentum; the other members are then meaningless.
};

}  // namespace kagero

/// The surfaces of a scene as the kernels see them. Part of the binary interface (abi.h).
#pragma once

#include <cstdint>

namespace kagero {

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

}  // namespace kagero

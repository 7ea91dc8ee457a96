/// A map over all directions of view from one point: where the rays reach the sky. It is refined where the view looks,
/// and is used again as long as the rays from this point remain the same.
///
/// The directions are the points of a cube around the observer. Each face is divided into blocks, and each block into
/// cells with rays at their corners. Inside a cell, the direction on the sky is interpolated bilinearly. Its error is
/// at most (h² |∂²f/∂s²| + h² |∂²f/∂t²|) / 8 for cells of size h; the second differences of the rays at the corners
/// estimate the derivatives. Rays in cells with too large an error must be traced.
#pragma once

#include "view/sky_ends.h"

namespace kagero {

/// A point on the cube of directions.
struct CubePoint {
    std::uint32_t block;  ///< Number of the block, over all faces.
    float s, t;           ///< Position in the block, from 0 to 1.
    float depth;          ///< Component of the direction along the normal of the face.
};
/// Returns the point for a direction of any length.
CubePoint cube_point(const Double3& direction);
/// Returns the direction of a point; its component along the normal of the face is 1.
Double3 direction_of(std::uint32_t block, double s, double t);

/// A block of cells.
struct MapBlock {
    std::uint32_t cells = 0;           ///< Number of cells along an edge; 0: the block has no rays yet.
    std::vector<SkyEnd> corners;       ///< (cells + 1)² ends of rays, row by row.
    /// For each cell, the estimated error of the direction in radians; infinity if the rays of the cell must be traced.
    std::vector<float> error;
    std::vector<float> magnification;  ///< For each cell, angle on the sky per length on the face of the cube.
};

class DirectionMap {
public:
    static constexpr std::uint32_t blocks_per_edge = 16, block_count = 6 * blocks_per_edge * blocks_per_edge;
    static constexpr double block_width = 2.0 / blocks_per_edge;  ///< On a face, whose half-width is 1.

    DirectionMap() : blocks_(block_count) {}
    /// Refines blocks until the error of their cells is at most `max_error` radians, or their cells are not wider than
    /// `least_width` on the face. The first cells of a block are not wider than `first_width`, so that they miss no
    /// details. The rays are those of the plan's camera.
    void refine(const Plan& plan, const std::vector<std::uint32_t>& blocks, double max_error, double first_width,
                double least_width);
    const MapBlock& block(std::uint32_t index) const { return blocks_[index]; }
    std::uint64_t rays() const { return rays_; }  ///< Returns the number of rays traced since the map was made.
    double seconds() const { return seconds_; }   ///< Returns the time of tracing since the map was made.

private:
    void trace(const Plan& plan, const std::vector<std::uint32_t>& blocks, double first_width);

    std::vector<MapBlock> blocks_;
    std::uint64_t corner_count_ = 0, rays_ = 0;
    double seconds_ = 0;
};

}  // namespace kagero

/// A map over all directions of view from one point: where the rays reach the sky. It is refined where the view looks,
/// and is used again as long as the rays from this point remain the same.
///
/// The directions are the points of a cube around the observer. Each face is divided into blocks, and each block into
/// cells with rays at their corners. Inside a cell, the direction on the sky is interpolated bilinearly. Its error is
/// at most (h² |∂²f/∂s²| + h² |∂²f/∂t²|) / 8 for cells of size h; the second differences of the rays at the corners
/// estimate the derivatives. Rays in cells with too large an error must be traced.
#pragma once

#include "view/sky/map_end.h"

#include <algorithm>
#include <cmath>

namespace kagero {

/// A point on the cube of directions.
struct CubePoint {
    std::uint32_t block;  ///< Number of the block, over all faces.
    float s, t;           ///< Position in the block, from 0 to 1.
    float inverse_depth;  ///< 1 / the component of the direction along the normal of the face.
};
/// Returns the direction of a point; its component along the normal of the face is 1.
Double3 direction_of(std::uint32_t block, double s, double t);

/// A block of cells.
struct MapBlock {
    std::uint32_t cells = 0;      ///< Number of cells along an edge; 0: the block has no rays yet.
    std::vector<SkyEnd> corners;  ///< (cells + 1)² ends of rays, row by row.
    /// For each cell, the estimated error of the direction in radians; infinity if the rays of the cell must be traced.
    std::vector<float> error;
    std::vector<float> magnification;  ///< For each cell, angle on the sky per length on the face of the cube.
};

/// The blocks of the map: on each face, whose half-width is 1, and in all.
inline constexpr std::uint32_t map_blocks_per_edge = 16,
                               map_block_count = 6 * map_blocks_per_edge * map_blocks_per_edge;
inline constexpr double map_block_width = 2.0 / map_blocks_per_edge;

/// Returns the point for a direction of any length. Inlined, because it is called for every pixel.
inline CubePoint cube_point(const Double3& d) {
    constexpr double edge = map_blocks_per_edge, below_edge = edge * (1 - 1e-9);
    const double x = std::abs(d[0]), y = std::abs(d[1]), z = std::abs(d[2]);
    const std::uint32_t axis = x >= y ? (x >= z ? 0 : 2) : (y >= z ? 1 : 2);
    const double inverse = 1 / std::abs(d[axis]), first = axis == 0 ? d[1] : d[0], second = axis == 2 ? d[1] : d[2],
                 s = std::clamp((first * inverse + 1) * (0.5 * edge), 0.0, below_edge),
                 t = std::clamp((second * inverse + 1) * (0.5 * edge), 0.0, below_edge);
    const auto column = static_cast<std::uint32_t>(s), row = static_cast<std::uint32_t>(t);
    const std::uint32_t face = 2 * axis + (d[axis] < 0);
    return {(face * map_blocks_per_edge + row) * map_blocks_per_edge + column, float(s - column), float(t - row),
            float(inverse)};
}

/// The points of a row of directions, in arrays that the compiler can vectorize. They agree with cube_point up to the
/// rounding of floats.
struct CubeRow {
    std::vector<std::uint32_t> face;
    std::vector<float> s, t;  ///< Position on the face, in blocks.
    std::vector<float> inverse_depth;

    /// Computes the points of `count` directions: first, first + step, ….
    void set(const Double3& first, const Double3& step, std::uint32_t count);
    /// Returns point number i.
    CubePoint operator[](std::uint32_t i) const {
        const auto column = static_cast<std::uint32_t>(s[i]), row = static_cast<std::uint32_t>(t[i]);
        return {(face[i] * map_blocks_per_edge + row) * map_blocks_per_edge + column, s[i] - float(column),
                t[i] - float(row), inverse_depth[i]};
    }
};

class DirectionMap {
public:
    using Row = CubeRow;

    DirectionMap() : blocks_(map_block_count) {}
    /// Refines blocks until the error of their cells is at most `max_error` radians, or their cells are not wider than
    /// `least_width` on the face. The first cells of a block are not wider than `first_width`, so that they miss no
    /// details. The rays are those of the plan's camera.
    void refine(const Plan& plan, const std::vector<std::uint32_t>& blocks, double max_error, double first_width,
                double least_width);
    const MapBlock& block(std::uint32_t index) const { return blocks_[index]; }
    /// Sets the points of `count` directions: first, first + step, ….
    static void set_row(Row& row, const Double3& first, const Double3& step, std::uint32_t count) {
        row.set(first, step, count);
    }
    /// Returns the interpolated end of the ray in direction number i of a row.
    MapEnd end_at(const Row& row, std::uint32_t i) const {
        MapEnd end;
        const CubePoint point = row[i];
        const MapBlock& block = blocks_[point.block];
        if (block.cells == 0) return end;
        const float cells = float(block.cells), s = point.s * cells, t = point.t * cells;
        const std::uint32_t column = std::min(std::uint32_t(s), block.cells - 1),
                            line = std::min(std::uint32_t(t), block.cells - 1), cell = line * block.cells + column;
        const SkyEnd* const upper = &block.corners[line * (block.cells + 1) + column];
        const SkyEnd* const lower = upper + block.cells + 1;
        const float right = s - float(column), down = t - float(line), lower_right = right * down,
                    upper_right = right - lower_right, lower_left = down - lower_right,
                    upper_left = 1 - right - lower_left;
        for (std::size_t k = 0; k < 3; ++k)
            end.direction[k] = upper_left * upper[0].direction[k] + upper_right * upper[1].direction[k] +
                               lower_left * lower[0].direction[k] + lower_right * lower[1].direction[k];
        end.kind = upper->kind;
        end.error = block.error[cell];
        end.magnification = block.magnification[cell] * point.inverse_depth;
        return end;
    }
    std::uint64_t rays() const { return rays_; }  ///< Returns the number of rays traced since the map was made.
    double seconds() const { return seconds_; }   ///< Returns the time of tracing since the map was made.

private:
    void trace(const Plan& plan, const std::vector<std::uint32_t>& blocks, double first_width);

    std::vector<MapBlock> blocks_;
    std::uint64_t corner_count_ = 0, rays_ = 0;
    double seconds_ = 0;
};

}  // namespace kagero

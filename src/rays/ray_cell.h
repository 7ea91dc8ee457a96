/// A square cell of the picture in which the ends of rays are interpolated.
#pragma once

#include "kernels/abi.h"

#include <array>

namespace kagero {

/// A square cell of pixels whose rays end alike: with the same status, on the same sky or face. Rays were traced at 3 ×
/// 3 nodes, at the distances 0, edge / 2 and edge from the first pixel, and in the middle of the four quarters. Both
/// are listed row by row. The nodes with the distance `edge` lie in other cells.
struct RayCell {
    std::uint32_t x, y;  ///< The first pixel, as its position on the film.
    std::uint32_t edge;  ///< Number of pixels along an edge: a power of two, at least 8.
    std::array<RayEnd, 9> nodes;
    std::array<RayEnd, 4> tests;
    double error;  ///< Estimated error of the interpolated ends, in pixels.

    /// Position of node i, relative to the first pixel.
    std::array<std::uint32_t, 2> node_position(std::uint32_t i) const { return {i % 3 * edge / 2, i / 3 * edge / 2}; }
    /// Position of test ray i, relative to the first pixel.
    std::array<std::uint32_t, 2> test_position(std::uint32_t i) const {
        return {edge / 4 * (1 + 2 * (i % 2)), edge / 4 * (1 + 2 * (i / 2))};
    }
    /// Returns true if the ray of a pixel was traced. The position is relative to the first pixel.
    bool is_traced(std::uint32_t u, std::uint32_t v) const {
        const std::uint32_t half = edge / 2, quarter = edge / 4;
        return (u % half == 0 && v % half == 0) || (u % half == quarter && v % half == quarter);
    }
};

}  // namespace kagero

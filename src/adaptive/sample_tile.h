/// Adaptive sampling of the picture plane: rays are traced where the picture changes abruptly, and at the nodes of
/// coarse cells elsewhere. The ends of all other rays are interpolated, with an estimate of the error.
#pragma once

#include "adaptive/ray_nodes.h"

#include <vector>

namespace kagero {

/// Edge of the tiles of an adaptively sampled picture, in pixels. It is a multiple of the edge of the largest cells.
inline constexpr std::uint32_t adaptive_tile_edge = 64;

/// Data about a sampled tile in addition to its ray ends.
struct AdaptiveSamples {
    /// Pixels of a cell whose ends are interpolated.
    struct Interpolated {
        std::uint32_t pixels;  ///< Number of pixels of the tile.
        double error;          ///< The estimated error, in pixels.
    };
    RayNodes nodes;  ///< All rays that were traced, including those outside the tile.
    std::vector<Interpolated> interpolated;
};

/// Traces as many rays of a tile as are necessary to interpolate the ends of the others. Sets `rays.cells`, and
/// `rays.ends` and `rays.traced` of all other pixels, row by row. All rays pass through the centres of pixels, as in
/// the full picture. The results are meaningless if `cancel` returned true.
///
/// The tile is divided into square cells of at most 32 × 32 pixels. A cell has 3 × 3 nodes and four test rays in the
/// middle of its quarters. Ends in the cell are interpolated on three conditions. All nine nodes end alike, with the
/// same status, sky and face. keeps_clear finds that no ray between them meets another surface. The interpolated ends
/// of the test rays differ from the traced ones by at most `bound` pixels. Otherwise, the cell is divided into four. In
/// cells of 8 × 8 pixels that cannot be interpolated, all rays are traced. Cells are aligned with the film, so the
/// result depends neither on tiles nor on the window.
void sample_tile(const Plan& plan, const Job& job, const Tile& tile, double bound, TracedRays& rays,
                 AdaptiveSamples& samples, Counters& counters, const CancelToken& cancel);

}  // namespace kagero

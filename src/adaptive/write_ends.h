/// Ray ends of the pixels of cells.
#pragma once

#include "paths/trace_paths.h"

namespace kagero {

/// Sets `rays.ends` and `rays.traced` for those pixels of a cell that lie in the tile of the rays: to the traced ends
/// where rays were traced, and to interpolated ends elsewhere.
void write_ends(const RayCell& cell, const Tile& tile, TracedRays& rays);

/// Does the same for all of `rays.cells`.
void write_ends(const Tile& tile, TracedRays& rays);

/// Returns the four quarters of a cell with at least 16 pixels along an edge. The ends of their nodes and test rays are
/// interpolated.
std::array<RayCell, 4> quarters_of(const RayCell& cell);

}  // namespace kagero

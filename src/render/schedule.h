/// Division of a picture into tiles, and the order in which threads take them. No pixel depends on it.
#pragma once

#include "plan/plan.h"

#include <vector>

namespace kagero {

/// Returns the schedule that the plan requests, or the best one if it requests none. The best is `predicted` with few
/// tiles per thread or many rays per pixel, unless rays are straight and have equal costs. Otherwise it is `tiles`.
Schedule schedule_of(const Plan& plan);

/// Tiles in the order in which threads take them.
struct WorkList {
    std::vector<Tile> tiles;
    std::vector<double> costs;  ///< Cost of each tile in any common unit; the progress is the finished share of it.
};

/// Splits a window of the film into tiles. Edges are at multiples of the packet size, counted from the film's corner,
/// so that the packets do not depend on the window or the schedule. The cost of a tile is its number of rays.
WorkList split_into_tiles(const Plan& plan, const Tile& window, Schedule schedule);

void sort_by_descending_cost(WorkList& work);

}  // namespace kagero

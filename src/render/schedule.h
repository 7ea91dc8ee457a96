/// Division of a picture into tiles, and the order in which threads take them. Pixels depend on neither.
#pragma once

#include "plan/plan.h"

#include <vector>

namespace kagero {

/// Returns the schedule that the plan requests. If the plan requests none, returns `predicted` for few tiles per thread
/// or many rays per pixel, and otherwise `tiles`. Straight rays have equal costs, so the result for them is `tiles`.
Schedule schedule_of(const Plan& plan);

/// Tiles in the order in which threads take them.
struct WorkList {
    std::vector<Tile> tiles;
    std::vector<double> costs;  ///< Cost of each tile, in any unit. The progress is the finished share of all costs.
};

/// Splits a window of the film into tiles. Inside the window, edges of tiles are at multiples of the tile size, counted
/// from the film's corner. Packets therefore do not depend on the window or the schedule. The cost of a tile is its
/// number of rays.
WorkList split_into_tiles(const Plan& plan, const Tile& window, Schedule schedule);

/// Sorts the tiles so that threads take the most expensive tiles first.
void sort_by_descending_cost(WorkList& work);

}  // namespace kagero

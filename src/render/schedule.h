/// Division of a picture into tiles, and the order in which threads take them. Pixels depend on neither.
#pragma once

#include "plan/plan.h"

#include <vector>

namespace kagero {

/// Returns the schedule that the plan requests. If the plan requests none, returns `predicted` for few tiles per thread
/// or many rays per pixel, and otherwise `tiles`. Straight rays have equal costs, so the result for them is `tiles`.
Schedule schedule_of(const Plan& plan);

/// A division of a window of the film into tiles. Inside the window, edges of tiles are at multiples of the tile size,
/// counted from the film's corner. Packets therefore do not depend on the window or the schedule. Tiles are numbered
/// row by row.
struct TileGrid {
    Tile window;
    std::uint32_t width, height;  ///< Size of a tile, in pixels.

    std::uint64_t columns() const;
    std::uint64_t count() const;  ///< Returns the number of tiles.
    Tile tile(std::uint64_t index) const;
    std::uint64_t index_of(const Tile& tile) const;
};

/// Returns the division of a window for a schedule. The schedules `tiles` and `predicted` have the same tiles.
TileGrid tile_grid(const Plan& plan, const Tile& window, Schedule schedule);

/// Tiles in the order in which threads take them.
struct WorkList {
    std::vector<Tile> tiles;
    std::vector<double> costs;  ///< Cost of each tile, in any unit. The progress is the finished share of all costs.
};

/// Returns all tiles of a grid. The cost of a tile is its number of rays.
WorkList split_into_tiles(const Plan& plan, const TileGrid& grid);
/// Splits a window of the film into the tiles of its grid.
WorkList split_into_tiles(const Plan& plan, const Tile& window, Schedule schedule);

/// Sorts the tiles so that threads take the most expensive tiles first.
void sort_by_descending_cost(WorkList& work);

}  // namespace kagero

/// Measurements of a run, tile by tile.
#pragma once

#include "kernels/abi.h"

#include <vector>

namespace kagero {

/// Measurements of one tile. Times are in seconds and are counted from the end of the prediction of costs.
struct TileRecord {
    Tile tile;
    unsigned thread;
    double begin;           ///< Time when the work on the tile began.
    double listed;          ///< Time when its RayList was complete; equal to `begin` if the kernel generates the rays.
    double traced;          ///< Time when its rays were traced.
    double end;             ///< Time when its pixels were shaded; 0 if the tile was cancelled.
    double processor_time;  ///< Processor time of the thread for this tile, in seconds.
    double predicted;       ///< Predicted cost of the tile (WorkList::costs).
    bool has_tick_counts;   ///< True if `ticks` and the ticks in `counters` were measured.
    std::uint64_t ticks;    ///< Ticks of rdtsc during tracing.
    Counters counters;
};

/// Measurements of all tiles, in the order in which threads take them.
struct Recording {
    /// Index of this recording among the repeated recordings of a picture. Ticks are counted in the tiles i for which
    /// i + round is a multiple of 4.
    std::size_t round = 0;
    std::vector<TileRecord> tiles;
};

}  // namespace kagero

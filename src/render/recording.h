/// What a run leaves behind when it is watched tile by tile.
#pragma once

#include "kernels/abi.h"

#include <vector>

namespace kagero {

/// One tile. Times are seconds since the run began.
struct TileRecord {
    Tile tile;
    unsigned thread;
    double begin, listed, traced,
        end;  ///< its rays are listed (where the kernel does not make them), traced, then shaded
    double processor;                   ///< seconds of the thread's processor time: what the tile cost
    double predicted;                   ///< its cost in WorkList
    bool looked_into;  ///< clocks ran inside its tracing, too: `ticks`, and those of the counters, are known
    std::uint64_t ticks;                ///< of the processor's clock, of tracing
    Counters counters;
};

/// The tiles in the order in which they were handed out. Those that were not reached have `end` 0.
struct Recording {
    std::size_t round = 0;  ///< of several recordings of one picture: each looks into other tiles
    std::vector<TileRecord> tiles;
};

}  // namespace kagero

/// Distribution of the choices and finished tiles of a picture from rank 0 to the other ranks.
#pragma once

#include "parts/tile_file.h"
#include "plan/plan.h"
#include "ranks/communicator.h"

namespace kagero {

/// Collective: sends the header of a picture and the numbers of its finished tiles to the other ranks. Returns when
/// they are ready to render.
void share_tiles(Communicator& ranks, const TileFileHeader& header, const TileResults& results);

/// The picture as another rank has received it.
struct ReceivedTiles {
    TileFileHeader header;
    TileResults finished;  ///< Empty reports of the finished tiles.
};

/// Collective: receives what share_tiles sends. Throws InputError if `identity`, that of this rank's plan, differs from
/// the identity of the picture. The rank must call agree() when it is ready to render.
std::unique_ptr<ReceivedTiles> receive_tiles(Communicator& ranks, const Properties& identity);

}  // namespace kagero

/// The pixels of tiles as bytes: row by row for each layer, the number of pixels that follow (32 bits), and these
/// pixels. If all pixels of a row have the same bits, only the first one follows.
#pragma once

#include "film/film.h"
#include "parts/bytes.h"
#include "render/schedule.h"

namespace kagero {

/// Appends those pixels of a tile that are in the film.
void put_pixels(ByteWriter& writer, const Tile& tile, const Film& film);

/// Reads pixels that put_pixels has written for a film with the same layers and window, and writes them to the film if
/// it has planes. Throws InputError if the bytes are not such pixels.
void get_pixels(ByteReader& reader, const Tile& tile, Film& film);

}  // namespace kagero

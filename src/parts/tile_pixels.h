/// The pixels of a tile as bytes.
///
/// The bytes contain the layers of the film one after another, and the rows of a layer one after another. A row
/// consists of sections: the number of pixels in the section (32 bits), the number of pixels after them that equal the
/// last of them (32 bits), and the floats of the pixels. Large areas of a picture often have one colour, so that the
/// bytes are few. Floats are compared bit by bit.
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

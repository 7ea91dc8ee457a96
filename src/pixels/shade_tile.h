/// Ends of a tile's rays to the pixels of a film.
#pragma once

#include "pixels/shade.h"
#include "rays/list_rays.h"

#include <vector>

namespace kagero {

/// Whether pixels want to know what piece of the sky their rays stand for.
bool wants_footprints(const Plan& plan, const Film& film);

/// Shades the pixels of a tile that lie in the window `film` shows, in blocks of 2 × 2. `list` holds the tile's rays
/// where the kernel did not make them itself, `errors` one estimate per ray where a layer wants it; else they are
/// empty.
void shade_tile(const Plan& plan, const Tile& tile, const Tile& shown, const RayEnd* ends, const RayList& list,
                const std::vector<EndError>& errors, Film& film);

}  // namespace kagero

/// Computation of the pixels of a tile from the ends of its rays.
#pragma once

#include "pixels/shade.h"
#include "rays/list_rays.h"

#include <vector>

namespace kagero {

/// Returns true if the pixels of a film depend on the footprints of their rays on the sky.
bool needs_footprints(const Plan& plan, const Film& film);

/// Computes, in blocks of 2 × 2, those pixels of a tile that lie in the rectangle `shown`, and writes them to `film`.
/// `shown` is the part of the picture that the film covers. `ends` has one element per ray of the tile. `list` contains
/// the tile's rays if the kernel did not generate them; otherwise it is empty. `errors` contains one estimate per ray
/// if a layer needs it; otherwise it is empty.
void shade_tile(const Plan& plan, const Tile& tile, const Tile& shown, const RayEnd* ends, const RayList& list,
                const std::vector<EndError>& errors, Film& film);

}  // namespace kagero

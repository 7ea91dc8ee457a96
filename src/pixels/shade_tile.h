/// Computation of the pixels of a tile from the ends of its rays.
#pragma once

#include "paths/trace_paths.h"
#include "pixels/shade.h"

#include <vector>

namespace kagero {

/// Returns true if the pixels of a film depend on the footprints of their rays on the sky.
bool needs_footprints(const Plan& plan, const Film& film);

/// Computes, in blocks of 2 × 2, those pixels of a tile that lie in the rectangle `shown`, and writes them to `film`.
/// `shown` is the part of the picture that the film covers. `errors` contains one estimate per ray if a layer needs it;
/// otherwise it is empty. Cells of `rays` are shaded as units where possible; the ends of their rays are set elsewhere.
void shade_tile(const Plan& plan, const Tile& tile, const Tile& shown, TracedRays& rays,
                const std::vector<EndError>& errors, Film& film);

}  // namespace kagero

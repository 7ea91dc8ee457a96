/// Rendering of a picture: traces the tiles on several threads and computes the pixels.
#pragma once

#include "render/run.h"

namespace kagero {

/// Returns an empty film for the plan's pixels (View::window) and the scene's layers. Throws RunError if there is not
/// enough memory.
Film film_of(const Plan& plan, Planes planes = Planes::allocated);

/// Returns the grid of the tiles that render() traces for a film. It can cover a row and a column of pixels beyond the
/// film on each side, so that blocks of 2 × 2 pixels are complete.
TileGrid tile_grid_of(const Plan& plan, const Film& film);

/// A function that returns the estimated errors of the ray ends of a tile, one per ray. It is called from several
/// threads at once, for different tiles.
using TileErrors = std::function<std::vector<EndError>(const Tile&, const TracedRays&, const CancelToken&)>;

/// Renders into a film that film_of returned. If the run ends early, pixels of unfinished tiles stay unchanged. With
/// RunControl::tile_film_finished, the film needs no planes, because each tile is rendered into a film of its own. The
/// layers `position_error` and `rounding_error` need `estimate_errors`; render_with_errors in accuracy/end_errors.h
/// supplies it.
RunReport render(const Plan& plan, Film& film, const RunControl& control = {}, const TileErrors& estimate_errors = {});

}  // namespace kagero

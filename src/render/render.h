/// Renders a picture: tiles over threads, rays to pixels, counters to a report.
#pragma once

#include "render/run.h"

namespace kagero {

/// A film of the pixels that are asked for, with the scene's layers. Throws RunError where there is no memory for it.
Film film_of(const Plan& plan);

/// Estimates how wrong the ends of a tile's rays are, one estimate per ray. Called from several threads at once, for
/// different tiles.
using TileErrors = std::function<std::vector<EndError>(const Tile&, const RayEnd*, const RayList&, const Halt&)>;

/// Renders into a film of that size. Where the work is ended early the rest of the film stays as it is. The layers
/// `position_error` and `rounding_error` need `errors`: see render_with_errors in accuracy/end_errors.h, which supplies
/// them.
RunReport render(const Plan& plan, Film& film, const Watch& watch = {}, const TileErrors& errors = {});

}  // namespace kagero

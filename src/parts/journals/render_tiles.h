/// Rendering of a part of a picture, and of a picture that an earlier run has begun.
#pragma once

#include "parts/journals/journal.h"
#include "plan/plan.h"

namespace kagero {

/// Returns the header of the tile file for a tuned plan. `identity` is that of the plan, see identity.h.
TileFileHeader header_of(const Plan& plan, const Film& film, Properties identity, const PartNumber& part);

/// Throws InputError with the first difference if a journal with a header belongs to another render or part.
void check_same_render(const Journal& journal, const Properties& identity, const PartNumber& part);

/// Renders the tiles of the header's part that `results` does not contain, and adds them to film and results. If
/// `results` keeps records, the pixels are in these only, and the film needs no planes. Appends each tile to the
/// journal, if it is not null. The report contains the sums over all tiles in `results`.
RunReport render_tiles(const Plan& plan, const TileFileHeader& header, Film& film, TileResults& results,
                       Journal* journal, RunControl control);

}  // namespace kagero

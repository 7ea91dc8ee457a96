/// Rendering of one picture by all ranks.
#pragma once

#include "parts/journals/journal.h"
#include "plan/plan.h"
#include "ranks/rank_link.h"

namespace kagero {

/// Renders the tiles of the header that `results` does not contain, on all ranks. Every rank needs the same header and
/// results. Half of the tiles are divided before the render, and rank 0 deals out the others during the render, so that
/// all ranks end at about the same time. Rank 0 receives the pixels and reports of all tiles in film and results, and
/// appends the tiles to the journal if it is not null. Film and results of the other ranks do not change; their films
/// need no planes.
///
/// If `control.stop` is set on any rank, all ranks end early. For the exceptions, see JointWork::run. The report of
/// rank 0 contains the sums over all tiles in `results`.
RunReport render_on_ranks(Communicator& ranks, const Plan& plan, const TileFileHeader& header, Film& film,
                          TileResults& results, Journal* journal, const RunControl& control, LinkTimes times = {});

}  // namespace kagero

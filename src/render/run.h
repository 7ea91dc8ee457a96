/// Distribution of the tiles of a run to threads.
#pragma once

#include "paths/trace_paths.h"
#include "render/run_report.h"
#include "render/schedule.h"

#include <functional>
#include <vector>

namespace kagero {

/// A function that writes the rays of a tile to the list. It is called from several threads at once, for different
/// tiles.
using TileRays = std::function<void(const Tile&, RayList&)>;

/// A function that receives the traced rays of a tile: one per pixel, row by row, or one per ray of the list. It may
/// change them. If the token returns true, the function returns without storing a result. It is called from several
/// threads at once, for different tiles.
using TileDone = std::function<void(const Tile&, TracedRays&, const CancelToken&)>;

/// Traces all tiles. Every thread takes the next tile of the list as soon as it has finished one. If `rays` is empty,
/// the rays of a tile are those of the job's camera or ray list. The job is that of the medium of the camera, and
/// `choice` selects the branches of rays that continue at surfaces. If WorkList::costs is empty, all tiles have equal
/// weight in the progress. RunControl::snapshot is ignored. If `interpolation_bound` is not 0, sample_tile interpolates
/// ray ends up to this error in pixels; `rays` is then not used.
RunReport run_tiles(const Plan& plan, const Job& job, const WorkList& work, const TileRays& rays, const TileDone& done,
                    const RunControl& control = {}, BranchChoice choice = BranchChoice::stronger,
                    double interpolation_bound = 0);

}  // namespace kagero

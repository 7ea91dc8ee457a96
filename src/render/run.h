/// Distribution of the tiles of a run to threads.
#pragma once

#include "rays/list_rays.h"
#include "render/run_report.h"
#include "render/schedule.h"

#include <functional>
#include <vector>

namespace kagero {

/// A function that writes the rays of a tile to the list. It is called from several threads at once, for different
/// tiles.
using TileRays = std::function<void(const Tile&, RayList&)>;

/// A function object that returns true if the work on a tile is cancelled. Long computations on the tile must call it
/// from time to time.
struct CancelToken {
    bool (*is_cancelled)(void* user) = nullptr;
    void* user = nullptr;
    bool operator()() const { return is_cancelled && is_cancelled(user); }
    /// Makes the kernel call this token while it executes the job.
    void install(Job& job) const {
        job.cancelled = is_cancelled;
        job.cancel_user = user;
    }
};
/// A function that receives the ray ends of a tile: one per pixel, row by row, or one per ray of the list. If the token
/// returns true, the function returns without storing a result. It is called from several threads at once, for
/// different tiles.
using TileDone = std::function<void(const Tile&, const RayEnd*, const RayList&, const CancelToken&)>;

/// Returns the number of rays of a tile: those of the list, or one per pixel if the list is empty.
std::size_t ray_count_of(const Tile& tile, const RayList& list);

/// Traces the rays of a tile: those of `list`, or, if `list` is empty, those of the job's camera or ray list. Adds the
/// steps, gradients and queries to the counters.
void trace_tile(const KernelInfo& kernel, Job job, const Tile& tile, const RayList& list, std::vector<RayEnd>& ends,
                Counters& counters);

/// Traces all tiles. Every thread takes the next tile of the list as soon as it has finished one. If `rays` is empty,
/// the rays of a tile are those of the job's camera or ray list. If WorkList::costs is empty, all tiles have equal
/// weight in the progress. RunControl::snapshot is ignored.
RunReport run_tiles(const Plan& plan, const Job& job, const WorkList& work, const TileRays& rays, const TileDone& done,
                    const RunControl& control = {});

}  // namespace kagero

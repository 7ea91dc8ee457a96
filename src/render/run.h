/// Tiles over threads: the one place where work is shared out.
#pragma once

#include "rays/list_rays.h"
#include "render/run_report.h"
#include "render/schedule.h"

#include <functional>
#include <vector>

namespace kagero {

/// Lists the rays of a tile. Called, as TileDone is, from several threads at once, for different tiles.
using TileRays = std::function<void(const Tile&, RayList&)>;

/// Whether the work on a tile is to be given up: what takes long over one asks now and then.
struct Halt {
    bool (*asked)(void* user) = nullptr;
    void* user = nullptr;
    bool operator()() const { return asked && asked(user); }
    void tell(Job& job) const { job.halted = asked, job.halted_user = user; }
};
/// Takes the finished rays of one tile: one end per pixel, row by row, or one per ray of the list. Where it is told to
/// give up, it does so before it keeps anything.
using TileDone = std::function<void(const Tile&, const RayEnd*, const RayList&, const Halt&)>;

/// How many rays a tile has.
std::size_t rays_of(const Tile& tile, const RayList& list);

/// Traces the rays of a tile: those of a list, or of the job's camera or rays where the list is empty. Adds to the
/// counters.
void trace_tile(const KernelInfo& kernel, Job job, const Tile& tile, const RayList& list, std::vector<RayEnd>& ends,
                Counters& counters);

/// Every thread takes the next tile of the list as soon as it has finished one. Without `rays` a tile's rays are those
/// of the job's camera or list; without costs all tiles cost alike. Snapshots are not taken here.
RunReport run_tiles(const Plan& plan, const Job& job, const WorkList& work, const TileRays& rays, const TileDone& done,
                    const Watch& watch = {});

}  // namespace kagero

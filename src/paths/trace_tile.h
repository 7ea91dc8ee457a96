/// Tracing of the rays of one tile by one kernel.
#pragma once

#include "rays/list_rays.h"

#include <vector>

namespace kagero {

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

/// Returns the number of rays of a tile: those of the list, or one per pixel if the list is empty.
std::size_t ray_count_of(const Tile& tile, const RayList& list);

/// Traces the rays of a tile: those of `list`, or, if `list` is empty, those of the job's camera or ray list. Adds the
/// steps, gradients and queries to the counters. All rays end at the first surface.
void trace_tile(const KernelInfo& kernel, Job job, const Tile& tile, const RayList& list, std::vector<RayEnd>& ends,
                Counters& counters);

}  // namespace kagero

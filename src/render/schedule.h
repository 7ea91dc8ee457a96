/// In which pieces, and in which order, a picture is worked on. No pixel depends on it.
#pragma once

#include "plan/plan.h"

#include <vector>

namespace kagero {

/// What the plan asks for. If it leaves that open: `predicted` where that pays (with few tiles for each of several
/// threads, or many rays per pixel, unless rays are straight and cost alike), else `tiles`.
Schedule schedule_of(const Plan& plan);

/// Tiles in the order in which threads take them.
struct WorkList {
    std::vector<Tile> tiles;
    std::vector<double> costs;  ///< of each tile, in a unit of their own: what progress is measured in
};

/// Cuts a window of the film. Edges lie on multiples of a packet's, counted from the film's corner, so that every
/// packet is the same whatever the window and the schedule. Costs are numbers of rays.
WorkList cut(const Plan& plan, const Tile& window, Schedule schedule);

/// The costliest first.
void put_costliest_first(WorkList& work);

}  // namespace kagero

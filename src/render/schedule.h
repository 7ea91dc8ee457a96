/// In which pieces, and in which order, a picture is worked on. No pixel depends on it.
#pragma once

#include "plan/plan.h"

#include <string>
#include <vector>

namespace kagero {

enum class Schedule {
    scanline,   ///< line by line, as in Satoh (2003): bands as wide as the picture, or as a thread holds rays, and as high as a packet, from the top
    tiles,      ///< squares, row by row
    predicted,  ///< squares, the costliest first, by a sparse first pass
};

const std::vector<std::string>& schedule_names();
const char* name_of(Schedule schedule);

/// What the options ask for; `auto` is `predicted` where that pays: with few tiles for each of several threads, or many rays per pixel,
/// unless rays are straight and cost alike. Else it is `tiles`.
Schedule schedule_of(const Plan& plan);

/// Tiles in the order in which threads take them.
struct WorkList {
    std::vector<Tile> tiles;
    std::vector<double> costs;  ///< of each tile, in a unit of their own: what progress is measured in
};

/// Cuts a window of the film. Edges lie on multiples of a packet's, counted from the film's corner, so that every packet is the
/// same whatever the window and the schedule. Costs are numbers of rays.
WorkList cut(const Plan& plan, const Tile& window, Schedule schedule);

/// The costliest first.
void put_costliest_first(WorkList& work);

}  // namespace kagero

/// The rays of pixels, where the program makes them.
#pragma once

#include "render/run.h"

namespace kagero {

/// All rays of a tile, pixel by pixel, as many for each as the film asks for.
void list_rays(const Plan& plan, const Tile& tile, RayList& list);

}  // namespace kagero

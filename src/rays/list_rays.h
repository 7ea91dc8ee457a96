/// The rays of pixels, where the program makes them.
#pragma once

#include "rays/camera.h"

namespace kagero {

/// The rays of a tile, where the program makes them and not the kernel.
struct RayList {
    std::vector<RayStart> starts;
    std::vector<double> frequencies;  ///< CameraRay::frequency of each
};

/// All rays of a tile, pixel by pixel, film.spp for each.
void list_rays(const Plan& plan, const Tile& tile, RayList& list);

}  // namespace kagero

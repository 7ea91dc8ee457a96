/// Lists of camera rays, for cameras and films whose rays the kernels cannot generate (src/plan/view.h).
#pragma once

#include "rays/camera.h"

namespace kagero {

/// The rays of a tile.
struct RayList {
    std::vector<RayStart> starts;
    std::vector<double> frequencies;  ///< CameraRay::frequency of each ray.
};

/// Replaces the contents of `list` by the rays of a tile, row by row. Each pixel has film.spp consecutive rays.
void list_rays(const Plan& plan, const Tile& tile, RayList& list);

}  // namespace kagero

/// How much of the sky a ray stands for.
#pragma once

#include "render/shade.h"

namespace kagero {

/// The rays of a block of 2 × 2 pixels, those of a pixel after those of another, and their places on the picture in pixels.
struct Quad {
    std::vector<Sighting> rays;
    std::vector<std::array<double, 2>> places;
};

/// From the spread of the block's rays that escape to the same sky: over a pixel directions spread as much as over the block, by
/// the ratio of a pixel's size to the spread of the places, and each of the `spp` rays has its share of the pixel's area. Zero
/// where a ray is alone. A block is one of the film's grid, never of a tile or crop, so that no picture depends on those.
SkyFootprints footprints_of(const Plan& plan, const Quad& quad, std::uint32_t spp);

/// The footprint of directions at places.
Footprint spread_of(const std::vector<Double3>& directions, const std::vector<std::array<double, 2>>& places);

}  // namespace kagero

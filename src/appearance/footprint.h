/// How much of the sky, or of a surface, a ray stands for.
#pragma once

#include "appearance/pixel_sample.h"
#include "geometry/geometry.h"

namespace kagero {

/// The piece of the sky, and of a wormhole's far sky, that each ray of a pixel stands for.
struct SkyFootprints {
    Footprint near, far;
    bool torn = false;  ///< some rays of the block are captured, or escape to the other sky
};

/// The rays of a block of 2 × 2 pixels, those of a pixel after those of another, and their places on the picture in
/// pixels.
struct PixelBlock {
    std::vector<PixelSample> rays;
    std::vector<CameraRay> starts;  ///< what their `ray` points to
    std::vector<std::array<double, 2>> places;
    std::vector<bool> has_patch;
    std::vector<std::size_t> group;     ///< some of the rays, as those are found whose ends belong together
    std::vector<Double3> group_points;
    std::vector<std::array<double, 2>> group_places;
};

/// From the spread of the block's rays that escape to the same sky: over a pixel directions spread as much as over the
/// block, by the ratio of a pixel's size to the spread of the places, and each of the `spp` rays has its share of the
/// pixel's area. Zero where a ray is alone. A block is one of the film's grid, never of a tile or crop, so that no
/// picture depends on those.
SkyFootprints footprints_of(PixelBlock& block, std::uint32_t spp);

/// The patches of four rays, one per pixel of a whole block, that all meet the same face: the same as find_patches, in
/// fewer operations and without their places. False for other blocks, which stay as they are.
bool find_common_patch(const SceneGeometry& geometry, PixelBlock& block, std::uint32_t spp);

/// The patches of the block's rays: how the ends of those that meet the same face of the same object move with their
/// places on the picture, a linear map fitted to them. Of two rays, or a row of them, it is known along their line
/// alone; a ray alone has none.
void find_patches(const SceneGeometry& geometry, PixelBlock& block, std::uint32_t spp);

/// The linear map from places to points, for a step of one pixel.
Patch slope_of(const std::vector<Double3>& points, const std::vector<std::array<double, 2>>& places);

/// The footprint of directions at places.
Footprint spread_of(const std::vector<Double3>& directions, const std::vector<std::array<double, 2>>& places);

}  // namespace kagero

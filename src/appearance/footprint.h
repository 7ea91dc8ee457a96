/// Footprints on the sky and patches on surfaces, estimated from the differences between neighbouring rays.
#pragma once

#include "appearance/pixel_sample.h"
#include "geometry/geometry.h"

namespace kagero {

/// Footprints of the rays of a block. All rays of the block that escape to the same sky have the same footprint.
struct SkyFootprints {
    Footprint first_sheet;   ///< Footprint on the sky of the space, [sky].
    Footprint second_sheet;  ///< Footprint on the sky of a wormhole's second sheet, [sky.far].
    /// True if a ray of the block is captured, or if rays of the block reach both skies.
    bool discontinuous = false;
};

/// Rays of a block of 2 × 2 pixels, with the buffers that are used to find their footprints and patches. The rays of
/// one pixel are consecutive.
struct PixelBlock {
    Tile pixels{};  ///< The pixels: fewer than 2 × 2 at the edges of a tile.
    std::vector<PixelSample> rays;
    std::vector<CameraRay> starts;                       ///< The elements to which `PixelSample::ray` points.
    std::vector<std::array<double, 2>> film_positions;   ///< Positions of the rays on the picture, in pixels.
    std::vector<bool> has_patch;                         ///< True for the rays whose patch has been found.
    std::vector<std::size_t> group;                      ///< Indices of rays that hit the same face.
    std::vector<Double3> group_points;                   ///< End points or sky directions of the group.
    std::vector<std::array<double, 2>> group_positions;  ///< Film positions of the group.
};

/// The group of rays that a diffuse surface has scattered.
inline constexpr std::uint32_t scattered_group = 0xffffffff;
/// Returns true if a diffuse surface has sent the ray into a random direction.
inline bool is_scattered(const PixelSample& ray) { return ray.path && ray.path->scatterings > 0; }

/// Sets PixelSample::group: rays whose paths continue at the same surfaces are in the same group. Only the ends of such
/// rays depend continuously on the film position. The ends of scattered rays do not: their group is scattered_group,
/// and they have no footprint and no patch. Returns the number of the other groups.
std::uint32_t group_by_path(PixelBlock& block);

/// Returns true if all four rays of a block with one ray per pixel escape to the same sky, in the same group.
bool have_common_sky(const PixelBlock& block, std::uint32_t spp);

/// Returns the footprints of the block's rays in one group. The spread of the directions of all rays that escape to the
/// same sky is scaled from the spread of their film positions to the size of a pixel. The area is then divided among
/// the `spp` rays of the pixel. A footprint is zero if fewer than two rays of the block escape to its sky. Blocks are
/// aligned with the film, not with tiles or crops, so the result depends on neither.
SkyFootprints footprints_of(PixelBlock& block, std::uint32_t spp, std::uint32_t group = 0);

/// Finds the patches of a block of four pixels with one ray per pixel (`spp` = 1) whose rays all hit the same face. The
/// patches equal those of find_patches, but fewer operations and no film positions are needed. Returns false for other
/// blocks and leaves them unchanged.
bool find_common_patch(const SceneGeometry& geometry, PixelBlock& block, std::uint32_t spp);

/// Finds the patches of the block's rays. For all rays of a group that hit the same face of the same object, it fits a
/// linear map from film positions to end points. If the film positions lie on a line, displacements across the line map
/// to zero. A single ray has a zero patch.
void find_patches(const SceneGeometry& geometry, PixelBlock& block, std::uint32_t spp);

/// Returns the least-squares linear map from film positions to points, as displacements per pixel.
Patch fit_patch(const std::vector<Double3>& points, const std::vector<std::array<double, 2>>& positions);

/// Returns the footprint of one pixel, fitted to unit directions at film positions.
Footprint fit_footprint(const std::vector<Double3>& directions, const std::vector<std::array<double, 2>>& positions);

}  // namespace kagero

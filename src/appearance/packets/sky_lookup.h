/// Colours of the skies for many rays at once.
#pragma once

#include "appearance/footprint.h"
#include "appearance/paints.h"

#include <array>
#include <memory>
#include <span>

namespace kagero {

/// Collects rays that escape, and looks up the colours of their skies. The kernel module computes footprints, texture
/// coordinates and filters of up to 64 blocks or rays in one call. No result depends on the other rays.
class SkyLookup {
public:
    /// If `wants_footprints` is true, PixelSample::footprint is set for the rays of blocks, and footprints of rays on
    /// skies without a pattern are computed too. The other arguments must outlive this object.
    SkyLookup(const Module& module, const Paints& paints, bool wants_footprints);
    ~SkyLookup();

    /// Adds the rays of a block with `have_common_sky`. Their footprint is computed as in footprints_of. The rays must
    /// exist until `finish` returns.
    void add_block(std::span<PixelSample, 4> rays);
    /// Adds a ray with a known footprint.
    void add(PixelSample& ray, const Footprint& footprint);
    /// Sets PixelSample::source_color of all rays that were added.
    void finish();

private:
    class Collector;
    Collector& sky_of(const PixelSample& ray);

    const Module& module_;
    const Paints& paints_;
    bool wants_footprints_;
    std::array<std::unique_ptr<Collector>, 2> skies_;  ///< Indexed by SkyView::on_second_sheet; null until used.
};

}  // namespace kagero

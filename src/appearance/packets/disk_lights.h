/// Colours of disks that radiate as black bodies, for many rays at once.
#pragma once

#include "appearance/paints.h"
#include "appearance/redshift.h"

namespace kagero {

/// Collects rays that end on disks with a temperature, and computes the colours of their black bodies. The kernel
/// module integrates up to 64 spectra in one call. No result depends on the other rays.
class DiskLights {
public:
    /// `spacetime` is the argument of redshift_of. The other arguments must outlive this object.
    DiskLights(const Module& module, const Paints& paints, const Sources& sources, bool spacetime)
        : module_(module), paints_(paints), sources_(sources), spacetime_(spacetime) {}

    /// Adds a ray that ends on a disk with a temperature; it must exist until `finish` returns.
    void add(PixelSample& ray);
    /// Sets PixelSample::source_color of all rays that were added.
    void finish();

private:
    static constexpr std::size_t capacity = 64;

    const Module& module_;
    const Paints& paints_;
    const Sources& sources_;
    bool spacetime_;
    std::size_t count_ = 0;
    std::array<PixelSample*, capacity> rays_;
    std::array<double, capacity> kelvin_;
};

}  // namespace kagero

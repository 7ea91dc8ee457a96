/// The rays of a pixel, in groups that are independent of each other.
#pragma once

#include "rays/sampler.h"
#include "scene/description.h"

namespace kagero {

/// The division of the rays of a pixel into groups with independent random numbers. The rays of a group share one
/// sequence, whose points fill the pixel evenly. The spread of the means of the groups is then an unbiased estimate of
/// the error of the pixel, which a single sequence does not permit: its points are not independent.
///
/// There is one group, unless rays are random (diffuse surfaces, a lens) or the film has the layer `standard_error`.
class PixelRays {
public:
    /// Greatest number of groups. With n groups, the relative error of the estimate is about 1/√(2n).
    static constexpr std::uint32_t max_groups = 16;

    explicit PixelRays(const SceneDescription& scene);

    std::uint32_t groups() const { return groups_; }
    /// Returns the group of ray `index` of a pixel.
    std::uint32_t group_of(std::uint32_t index) const { return index % groups_; }
    /// Returns the identity of ray `index` of pixel (x, y).
    PixelRay ray(std::uint32_t x, std::uint32_t y, std::uint32_t index) const;
    /// Returns the position of ray `index` in pixel (x, y), relative to the pixel's upper left corner and in pixels.
    std::array<double, 2> position(std::uint32_t x, std::uint32_t y, std::uint32_t index) const;

private:
    std::uint32_t spp_, seed_, groups_ = 1;
};

}  // namespace kagero

/// Refractive indices that rays meet in media whose index varies.
#pragma once

#include "paths/interaction.h"

namespace kagero {

/// Radiance divided by the squared index is constant along a ray, in a medium and across its boundaries. In a medium
/// whose index varies, the radiance therefore changes between the boundaries. All light in a medium is stated relative
/// to the index where the path has first met a boundary of the medium, so a path that returns to a medium has the same
/// factor.
class MediumIndices {
public:
    /// Prepares for the paths of `rays` rays.
    void reset(const Plan& plan, std::size_t rays);
    /// Returns the ratio of the radiance before a boundary, seen along the ray, to that of the transmitted branch.
    double radiance_ratio(std::size_t ray, std::uint32_t medium, const SurfaceInteraction& interaction);

private:
    /// Returns the index of a medium for a ray, which is `index` unless the path has met another one in this medium.
    double index_of(std::size_t ray, std::uint32_t medium, double index);

    std::vector<bool> varies_;  ///< For each medium: true if its index varies.
    bool any_varies_ = false;
    std::vector<double> first_;  ///< For each ray and medium, the first index; 0: none yet. Empty if no index varies.
};

}  // namespace kagero

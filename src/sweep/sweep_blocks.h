/// Blocks of the rays of a sweep, which are traced one after another or by different processes.
#pragma once

#include "sweep/sweep.h"

namespace kagero {

/// Some rays for some of the sets.
struct SweepBlock {
    SetRange sets;
    std::size_t first_ray, rays;
};

/// The blocks of a sweep in the order of sets, then of rays. A block contains all rays of several sets, or some rays of
/// one set. The blocks depend only on the sweep.
class SweepBlocks {
public:
    SweepBlocks(const Sweep& sweep, std::size_t rays);

    std::size_t count() const { return blocks_of_sets_ * blocks_of_rays_; }
    SweepBlock block(std::size_t index) const;

private:
    std::size_t sets_, rays_;
    std::size_t sets_per_block_, rays_per_block_;  ///< Greatest numbers in one block.
    std::size_t blocks_of_sets_, blocks_of_rays_;
};

}  // namespace kagero

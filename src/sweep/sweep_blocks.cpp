#include "sweep/sweep_blocks.h"

#include <algorithm>

namespace kagero {
namespace {

/// A sweep has about this many blocks, unless they would be too small or too large.
constexpr std::size_t wanted_blocks = 256;
/// Least and greatest number of rays in one block, counted once for each set.
constexpr std::size_t least_rays = 2048, most_rays = 65536;

std::size_t quotient_rounded_up(std::size_t a, std::size_t b) { return (a + b - 1) / b; }

}  // namespace

SweepBlocks::SweepBlocks(const Sweep& sweep, std::size_t rays) : sets_(sweep.sets()), rays_(rays) {
    const std::size_t size = std::clamp(sets_ * rays / wanted_blocks, least_rays, most_rays);
    const bool whole_sets = rays <= size || sweep.has_separate_plans();
    sets_per_block_ = whole_sets && !sweep.has_separate_plans() ? size / std::max<std::size_t>(rays, 1) : 1;
    rays_per_block_ = whole_sets ? rays : size;
    blocks_of_sets_ = quotient_rounded_up(sets_, sets_per_block_);
    blocks_of_rays_ = rays > 0 ? quotient_rounded_up(rays, rays_per_block_) : 0;
}

SweepBlock SweepBlocks::block(std::size_t index) const {
    const std::size_t set = index / blocks_of_rays_ * sets_per_block_, ray = index % blocks_of_rays_ * rays_per_block_;
    return {{set, std::min(sets_per_block_, sets_ - set)}, ray, std::min(rays_per_block_, rays_ - ray)};
}

}  // namespace kagero

/// Ranges of the sets of a sweep, and the ends of their rays.
#pragma once

#include "kernels/abi.h"

#include <cstddef>
#include <vector>

namespace kagero {

/// The sets first, first + 1, … of a sweep.
struct SetRange {
    std::size_t first = 0, count = 0;

    bool contains(std::size_t set) const { return set >= first && set - first < count; }
};

/// The ends of the rays of a range of sets. Element (set − first) · rays + ray belongs to that set and ray.
struct EndsOfSets {
    SetRange range;
    std::size_t rays;
    std::vector<RayEnd>& ends;

    /// Returns the end of the first ray of a set of the range.
    RayEnd* of(std::size_t set) const { return ends.data() + (set - range.first) * rays; }
};

}  // namespace kagero

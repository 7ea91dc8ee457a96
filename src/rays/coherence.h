/// Coherence of the rays of a list, and an order of the rays that improves it.
#pragma once

#include "kernels/abi.h"

#include <cstdint>
#include <vector>

namespace kagero {

/// Returns true if consecutive rays of a list start with similar positions and similar directions of the momentum, on
/// average over a sample.
bool neighbours_are_coherent(const std::vector<RayStart>& rays);

/// Returns the indices of rays in an order in which neighbours start with similar positions and directions of the
/// momentum. The rays of a packet then take similar numbers of steps. The order is that of a Z-order curve (Morton
/// 1966) through positions and directions. Rays that end at their start come last.
std::vector<std::uint32_t> coherent_order(const std::vector<RayStart>& rays);

}  // namespace kagero

/// Which rays of a list go together.
#pragma once

#include "kernels/abi.h"

#include <cstdint>
#include <vector>

namespace kagero {

/// Whether rays that follow each other in a list start, as a rule, close together and in much the same direction; by a
/// sample.
bool neighbours_go_together(const std::vector<RayStart>& rays);

/// The places of rays in an order in which neighbours start close together and in much the same direction, so that the
/// rays of a packet take about as many steps: that of a Z-curve (Morton 1966) through positions and directions. Rays
/// that cannot start come last.
std::vector<std::uint32_t> coherent_order(const std::vector<RayStart>& rays);

}  // namespace kagero

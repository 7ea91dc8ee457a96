/// Vectors of the numbers of one ray.
#pragma once

#include "kernels/simd/lanes.h"

namespace kagero {
namespace detail {

/// Number of registers of a vector of n numbers of type S: 1, 2 or 4.
template <class S, int n>
inline constexpr int registers_for = n <= Lanes<S, 1>::width ? 1 : n <= 2 * Lanes<S, 1>::width ? 2 : 4;

}  // namespace detail

/// Vector type for n numbers of one ray. It may have more lanes than n.
template <class S, int n>
using Packed = Lanes<S, detail::registers_for<S, n>>;

}  // namespace kagero

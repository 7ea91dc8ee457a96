/// Where in a pixel its samples lie.
#pragma once

#include <array>
#include <cstdint>

namespace kagero {

/// Sample `index` of `count` in pixel (x, y) of the film: a point of the unit square, (½, ½) where there is only one. A
/// function of its arguments alone, so that no picture depends on who computes which pixel when.
///
/// The first two dimensions of Sobol's sequence (I. M. Sobol', USSR Comput. Math. Math. Phys. 7, 1967), a
/// (0,2)-sequence, shuffled and Owen-scrambled by hashing: B. Burley, Practical Hash-based Owen Scrambling, JCGT 9(4),
/// 2020. Every run of 2^k samples that starts at a multiple of 2^k has one sample in each of the 2^k cells of every
/// binary grid.
std::array<double, 2> place_in_pixel(std::uint32_t x, std::uint32_t y, std::uint32_t index, std::uint32_t count,
                                     std::uint32_t seed);

}  // namespace kagero

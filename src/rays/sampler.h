/// Positions of the rays in a pixel.
#pragma once

#include <array>
#include <cstdint>

namespace kagero {

/// Returns the position of ray `index` of `count` in pixel (x, y) of the film, relative to the pixel's upper left
/// corner and in pixels. A single ray is at (½, ½). The position depends only on the arguments, so a picture does not
/// depend on the order in which its pixels are computed.
///
/// The positions are the first two dimensions of Sobol's sequence (I. M. Sobol', USSR Comput. Math. Math. Phys. 7,
/// 1967), which is a (0,2)-sequence. They are shuffled and Owen-scrambled by hashing (B. Burley, Practical Hash-based
/// Owen Scrambling, JCGT 9(4), 2020). Every run of 2^k rays that starts at a multiple of 2^k has one ray in each
/// cell of every grid of 2^i × 2^(k−i) equal cells.
std::array<double, 2> sample_position(std::uint32_t x, std::uint32_t y, std::uint32_t index, std::uint32_t count,
                                      std::uint32_t seed);

/// Returns a number in [0, 1) for the random choice of ray `index` of pixel (x, y) at its surface number `bounce`. The
/// numbers of the rays of a pixel at the same bounce are a shuffled and Owen-scrambled van der Corput sequence.
double sample_number(std::uint32_t x, std::uint32_t y, std::uint32_t index, std::uint32_t seed, std::uint32_t bounce);

/// A ray of a pixel, for its random numbers: the pixel, the index of the ray among those that share one random
/// sequence, and the seed of that sequence.
struct PixelRay {
    std::uint32_t x, y, index, seed;
};

/// A random choice on the path of a ray, besides its position in the pixel and its branches at boundaries. Each pair of
/// a choice and a bounce has its own sequence of numbers.
enum class RandomChoice : std::uint32_t { direction, strategy, roulette, lens };

/// Returns a point in the unit square. The points of the rays of a pixel for the same choice at the same bounce are a
/// sequence like that of sample_position, and independent of all others.
std::array<double, 2> sample_square(const PixelRay& ray, RandomChoice choice, std::uint32_t bounce);

/// Returns a number in [0, 1): the first coordinate of sample_square.
double sample_number(const PixelRay& ray, RandomChoice choice, std::uint32_t bounce);

/// Returns the point in the unit disk that belongs to a point in the unit square, by the concentric map of P. Shirley
/// and K. Chiu (Journal of Graphics Tools 2(3), 1997). The map preserves ratios of areas.
std::array<double, 2> concentric_disk(const std::array<double, 2>& point);

}  // namespace kagero

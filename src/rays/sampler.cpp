#include "rays/sampler.h"

namespace kagero {
namespace {

std::uint32_t reversed(std::uint32_t x) {
    x = (x >> 16) | (x << 16);
    x = ((x & 0xff00ff00u) >> 8) | ((x & 0x00ff00ffu) << 8);
    x = ((x & 0xf0f0f0f0u) >> 4) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x & 0xccccccccu) >> 2) | ((x & 0x33333333u) << 2);
    return ((x & 0xaaaaaaaau) >> 1) | ((x & 0x55555555u) << 1);
}

/// Burley (2020), listing 2: a bit is changed by lower bits alone (Laine and Karras 2011).
std::uint32_t laine_karras(std::uint32_t x, std::uint32_t seed) {
    x += seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return x;
}

/// Owen's scrambling, of a number whose bits are in reverse order: there a bit is changed by higher bits alone.
std::uint32_t scrambled(std::uint32_t reverse, std::uint32_t seed) {
    return reversed(laine_karras(reverse, seed));
}

/// Sobol's second dimension, its bits in reverse order. The generator matrix is Pascal's triangle modulo 2 (T. Kollig
/// and A. Keller, 2002), where a binomial coefficient is odd if the bits of one number are among those of the other
/// (Lucas): bit k is the sum of the index's bits at all numbers that have the bits of k.
std::uint32_t sobol_second_reverse(std::uint32_t index) {
    index ^= (index >> 1) & 0x55555555u;
    index ^= (index >> 2) & 0x33333333u;
    index ^= (index >> 4) & 0x0f0f0f0fu;
    index ^= (index >> 8) & 0x00ff00ffu;
    return index ^ (index >> 16);
}

/// Every bit of the input to every bit of the output; constants found by C. Wellons (2018), "lowbias32".
std::uint32_t mixed(std::uint32_t x) {
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ (x >> 16);
}

}  // namespace

std::array<double, 2> place_in_pixel(std::uint32_t x, std::uint32_t y, std::uint32_t index, std::uint32_t count,
                                     std::uint32_t seed) {
    if (count == 1) return {0.5, 0.5};
    const std::uint32_t own = mixed(x ^ mixed(y ^ mixed(seed)));
    const std::uint32_t shuffled = scrambled(reversed(index), own);
    const std::uint32_t first = scrambled(shuffled, mixed(own ^ 0x9e3779b9u));
    const std::uint32_t second = scrambled(sobol_second_reverse(shuffled), mixed(own ^ 0x3c6ef372u));
    constexpr double unit = 1.0 / 4294967296.0;
    return {first * unit, second * unit};
}

}  // namespace kagero

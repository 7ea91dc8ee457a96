#include "rays/sampler.h"

#include <cmath>
#include <numbers>

namespace kagero {
namespace {

/// Returns x with its bits in reverse order.
std::uint32_t reverse_bits(std::uint32_t x) {
    x = (x >> 16) | (x << 16);
    x = ((x & 0xff00ff00u) >> 8) | ((x & 0x00ff00ffu) << 8);
    x = ((x & 0xf0f0f0f0u) >> 4) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x & 0xccccccccu) >> 2) | ((x & 0x33333333u) << 2);
    return ((x & 0xaaaaaaaau) >> 1) | ((x & 0x55555555u) << 1);
}

/// Returns a hash of x. The hash is a permutation in which a bit depends only on the same bit and on lower bits of x
/// (Laine and Karras 2011). The constants are those of Burley (2020), listing 2.
std::uint32_t laine_karras(std::uint32_t x, std::uint32_t seed) {
    x += seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return x;
}

/// Returns the Owen scrambling of a number, in which each bit is flipped depending only on the higher bits. `reversed`
/// contains the bits of the number in reverse order.
std::uint32_t owen_scrambled(std::uint32_t reversed, std::uint32_t seed) {
    return reverse_bits(laine_karras(reversed, seed));
}

/// Returns the second dimension of Sobol's sequence at `index`, with its bits in reverse order. The generator matrix is
/// Pascal's triangle modulo 2 (T. Kollig and A. Keller, 2002). The binomial coefficient of n and k is odd if every bit
/// of k is also set in n (Lucas). Therefore, bit k of the result is the exclusive or of the bits n of the index for all
/// such n.
std::uint32_t sobol_second_reversed(std::uint32_t index) {
    index ^= (index >> 1) & 0x55555555u;
    index ^= (index >> 2) & 0x33333333u;
    index ^= (index >> 4) & 0x0f0f0f0fu;
    index ^= (index >> 8) & 0x00ff00ffu;
    return index ^ (index >> 16);
}

/// Returns a hash in which every bit depends on every bit of x. The constants are those of "lowbias32" by C. Wellons
/// (2018).
std::uint32_t hash(std::uint32_t x) {
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ (x >> 16);
}

constexpr double sampler_unit = 1.0 / 4294967296.0;

std::uint32_t hash_of_pixel(std::uint32_t x, std::uint32_t y, std::uint32_t seed) {
    return hash(x ^ hash(y ^ hash(seed)));
}

/// Returns point `index` of a shuffled and Owen-scrambled sequence of Sobol.
std::array<double, 2> scrambled_point(std::uint32_t index, std::uint32_t seed) {
    const std::uint32_t shuffled = owen_scrambled(reverse_bits(index), seed);
    // The first dimension of Sobol's sequence is the index with its bits in reverse order. owen_scrambled expects the
    // bits of its number in reverse order, so it gets the index itself.
    const std::uint32_t first = owen_scrambled(shuffled, hash(seed ^ 0x9e3779b9u));
    const std::uint32_t second = owen_scrambled(sobol_second_reversed(shuffled), hash(seed ^ 0x3c6ef372u));
    return {first * sampler_unit, second * sampler_unit};
}

std::uint32_t seed_of(const PixelRay& ray, RandomChoice choice, std::uint32_t bounce) {
    return hash(hash(hash_of_pixel(ray.x, ray.y, ray.seed) ^ hash(bounce + 0x51ed270bu)) ^
                hash(static_cast<std::uint32_t>(choice) + 0x2545f491u));
}

}  // namespace

std::array<double, 2> sample_position(std::uint32_t x, std::uint32_t y, std::uint32_t index, std::uint32_t count,
                                      std::uint32_t seed) {
    if (count == 1) return {0.5, 0.5};
    return scrambled_point(index, hash_of_pixel(x, y, seed));
}

double sample_number(std::uint32_t x, std::uint32_t y, std::uint32_t index, std::uint32_t seed, std::uint32_t bounce) {
    const std::uint32_t bounce_seed = hash(hash_of_pixel(x, y, seed) ^ hash(bounce + 0x7f4a7c15u)),
                        shuffled = owen_scrambled(reverse_bits(index), bounce_seed);
    return owen_scrambled(shuffled, hash(bounce_seed ^ 0x9e3779b9u)) * sampler_unit;
}

std::array<double, 2> sample_square(const PixelRay& ray, RandomChoice choice, std::uint32_t bounce) {
    return scrambled_point(ray.index, seed_of(ray, choice, bounce));
}

double sample_number(const PixelRay& ray, RandomChoice choice, std::uint32_t bounce) {
    const std::uint32_t seed = seed_of(ray, choice, bounce), shuffled = owen_scrambled(reverse_bits(ray.index), seed);
    return owen_scrambled(shuffled, hash(seed ^ 0x9e3779b9u)) * sampler_unit;
}

std::array<double, 2> concentric_disk(const std::array<double, 2>& point) {
    const double u = 2 * point[0] - 1, v = 2 * point[1] - 1;
    if (u == 0 && v == 0) return {0, 0};
    const bool along_u = std::abs(u) > std::abs(v);
    const double radius = along_u ? u : v, quarter = std::numbers::pi / 4,
                 angle = along_u ? quarter * (v / u) : 2 * quarter - quarter * (u / v);
    return {radius * std::cos(angle), radius * std::sin(angle)};
}

}  // namespace kagero

/// Random numbers and smooth random functions. They hash integers and use no distribution of the standard library, so
/// the results do not depend on the platform.
#pragma once

#include <cmath>
#include <cstdint>

namespace textures {

struct Vec {
    double x = 0, y = 0, z = 0;
};

inline Vec operator*(double s, const Vec& a) {
    return {s * a.x, s * a.y, s * a.z};
}
inline Vec operator+(const Vec& a, const Vec& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline double dot(const Vec& a, const Vec& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// Returns the hash of 64 bits by the finalizer of SplitMix64, Steele, Lea and Flood (2014).
constexpr std::uint64_t hash(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

/// Returns a number in [0, 1) from the upper 53 of 64 random bits.
constexpr double to_unit_interval(std::uint64_t bits) {
    return static_cast<double>(bits >> 11) * 0x1p-53;
}

/// Returns the random number in [0, 1) that belongs to the lattice point (i, j, k).
constexpr double lattice_random(std::uint64_t seed, std::int64_t i, std::int64_t j = 0, std::int64_t k = 0) {
    std::uint64_t h = hash(seed ^ static_cast<std::uint64_t>(i));
    h = hash(h ^ static_cast<std::uint64_t>(j));
    return to_unit_interval(hash(h ^ static_cast<std::uint64_t>(k)));
}

/// A pseudorandom sequence of numbers in [0, 1).
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    double operator()() { return to_unit_interval(hash(state_++)); }
    /// Returns the next number, scaled to [low, high).
    double between(double low, double high) { return low + (high - low) * (*this)(); }
    /// Returns a normally distributed number with mean 0 and standard deviation 1, Box and Muller (1958).
    double normal() {
        const double radius = std::sqrt(-2 * std::log(1 - (*this)()));
        return radius * std::cos(6.283185307179586 * (*this)());
    }

private:
    std::uint64_t state_;
};

/// Interpolates linearly from a (t = 0) to b (t = 1).
constexpr double mix(double a, double b, double t) {
    return a + (b - a) * t;
}

/// Rises from 0 at `low` to 1 at `high` by a cubic polynomial; constant outside.
constexpr double smoothstep(double low, double high, double x) {
    const double t = x <= low ? 0 : x >= high ? 1 : (x - low) / (high - low);
    return t * t * (3 - 2 * t);
}

/// Returns value noise in [−1, 1]: random values at the lattice points, interpolated with continuous second
/// derivatives. If `period` > 0, the noise repeats after that many lattice cells along every axis.
inline double noise(std::uint64_t seed, const Vec& p, std::int64_t period = 0) {
    const double floors[] = {std::floor(p.x), std::floor(p.y), std::floor(p.z)};
    const double offset[] = {p.x - floors[0], p.y - floors[1], p.z - floors[2]};
    double weight[3], sum = 0;
    std::int64_t cell[3];
    for (int a = 0; a < 3; ++a) {
        const double t = offset[a];
        weight[a] = t * t * t * (t * (6 * t - 15) + 10);
        cell[a] = static_cast<std::int64_t>(floors[a]);
    }
    const auto repeated = [period](std::int64_t i) { return period > 0 ? ((i % period) + period) % period : i; };
    for (int corner = 0; corner < 8; ++corner) {
        const int step[] = {corner & 1, (corner >> 1) & 1, corner >> 2};
        double corner_weight = 1;
        for (int a = 0; a < 3; ++a) corner_weight *= step[a] ? weight[a] : 1 - weight[a];
        sum += corner_weight * lattice_random(seed, repeated(cell[0] + step[0]), repeated(cell[1] + step[1]),
                                              repeated(cell[2] + step[2]));
    }
    return 2 * sum - 1;
}

/// Returns the weighted mean of several octaves of noise, about −1 to 1. Each octave has twice the frequency and `gain`
/// times the amplitude of the octave before it.
inline double fractal_noise(std::uint64_t seed, Vec p, int octaves, double gain = 0.5, std::int64_t period = 0) {
    double sum = 0, strength = 1, total = 0;
    for (int octave = 0; octave < octaves; ++octave, strength *= gain, p = 2.0 * p, period *= 2) {
        sum += strength * noise(seed + static_cast<std::uint64_t>(octave), p, period);
        total += strength;
    }
    return sum / total;
}

/// Returns ridged fractal noise in [0, 1]. It is close to 1 along the surfaces on which the noise is zero.
inline double ridged_noise(std::uint64_t seed, Vec p, int octaves, double gain = 0.55) {
    double sum = 0, strength = 1, total = 0;
    for (int octave = 0; octave < octaves; ++octave, strength *= gain, p = 2.0 * p) {
        const double ridge = 1 - std::abs(noise(seed + static_cast<std::uint64_t>(octave), p));
        sum += strength * ridge * ridge;
        total += strength;
    }
    return sum / total;
}

}  // namespace textures

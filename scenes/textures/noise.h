/// Random numbers and smooth random functions that are the same everywhere: integers hashed, no library distribution.
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

/// Steele, Lea, Flood (2014), SplitMix64: the finalizer.
constexpr std::uint64_t hashed(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

constexpr double fraction(std::uint64_t bits) {
    return static_cast<double>(bits >> 11) * 0x1p-53;
}

/// In [0, 1), one value per lattice point.
constexpr double random_at(std::uint64_t seed, std::int64_t i, std::int64_t j = 0, std::int64_t k = 0) {
    std::uint64_t h = hashed(seed ^ static_cast<std::uint64_t>(i));
    h = hashed(h ^ static_cast<std::uint64_t>(j));
    return fraction(hashed(h ^ static_cast<std::uint64_t>(k)));
}

/// A sequence of numbers in [0, 1).
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    double operator()() { return fraction(hashed(state_++)); }
    double between(double low, double high) { return low + (high - low) * (*this)(); }
    /// Normal, mean 0, deviation 1: Box and Muller (1958).
    double normal() {
        const double radius = std::sqrt(-2 * std::log(1 - (*this)()));
        return radius * std::cos(6.283185307179586 * (*this)());
    }

private:
    std::uint64_t state_;
};

constexpr double mixed(double a, double b, double t) {
    return a + (b - a) * t;
}

constexpr double smooth(double low, double high, double x) {
    const double t = x <= low ? 0 : x >= high ? 1 : (x - low) / (high - low);
    return t * t * (3 - 2 * t);
}

/// Lattice values in −1…1, joined smoothly. `period` > 0 repeats it along all axes.
inline double noise(std::uint64_t seed, const Vec& p, std::int64_t period = 0) {
    const double floors[] = {std::floor(p.x), std::floor(p.y), std::floor(p.z)};
    const double rest[] = {p.x - floors[0], p.y - floors[1], p.z - floors[2]};
    double weight[3], sum = 0;
    std::int64_t cell[3];
    for (int a = 0; a < 3; ++a) {
        const double t = rest[a];
        weight[a] = t * t * t * (t * (6 * t - 15) + 10);
        cell[a] = static_cast<std::int64_t>(floors[a]);
    }
    const auto repeated = [period](std::int64_t i) { return period > 0 ? ((i % period) + period) % period : i; };
    for (int corner = 0; corner < 8; ++corner) {
        const int step[] = {corner & 1, (corner >> 1) & 1, corner >> 2};
        double share = 1;
        for (int a = 0; a < 3; ++a) share *= step[a] ? weight[a] : 1 - weight[a];
        sum += share *
               random_at(seed, repeated(cell[0] + step[0]), repeated(cell[1] + step[1]), repeated(cell[2] + step[2]));
    }
    return 2 * sum - 1;
}

/// Octaves of noise, each twice as fine and `gain` times as strong as the last; about −1…1.
inline double fractal(std::uint64_t seed, Vec p, int octaves, double gain = 0.5, std::int64_t period = 0) {
    double sum = 0, strength = 1, total = 0;
    for (int octave = 0; octave < octaves; ++octave, strength *= gain, p = 2.0 * p, period *= 2) {
        sum += strength * noise(seed + static_cast<std::uint64_t>(octave), p, period);
        total += strength;
    }
    return sum / total;
}

/// As fractal(), with its zeros drawn out into ridges: 0…1, near 1 on threads.
inline double threads(std::uint64_t seed, Vec p, int octaves, double gain = 0.55) {
    double sum = 0, strength = 1, total = 0;
    for (int octave = 0; octave < octaves; ++octave, strength *= gain, p = 2.0 * p) {
        const double ridge = 1 - std::abs(noise(seed + static_cast<std::uint64_t>(octave), p));
        sum += strength * ridge * ridge;
        total += strength;
    }
    return sum / total;
}

}  // namespace textures

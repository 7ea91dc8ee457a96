#include "render/coherence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace kagero {
namespace {

constexpr std::size_t dimensions = 6;  ///< position, unit direction
constexpr int bits = 10;               ///< of each

using Coordinates = std::array<double, dimensions>;

bool starts(const RayStart& ray) { return ray.failure == Failure::none && !ray.captured && !ray.escaped; }

Coordinates coordinates_of(const RayStart& ray) {
    const double inverse = 1 / std::hypot(ray.p[0], ray.p[1], ray.p[2]);
    return {ray.q[0], ray.q[1], ray.q[2], ray.p[0] * inverse, ray.p[1] * inverse, ray.p[2] * inverse};
}

/// The smallest box around all rays; flat in the dimensions that they share.
struct Box {
    Coordinates least, greatest;

    Box() {
        least.fill(std::numeric_limits<double>::infinity()), greatest.fill(-std::numeric_limits<double>::infinity());
    }
    void add(const Coordinates& at) {
        for (std::size_t k = 0; k < dimensions; ++k) least[k] = std::min(least[k], at[k]), greatest[k] = std::max(greatest[k], at[k]);
    }
    /// The greatest distance along any dimension, as a share of the box.
    double distance(const Coordinates& a, const Coordinates& b) const {
        double most = 0;
        for (std::size_t k = 0; k < dimensions; ++k)
            if (greatest[k] > least[k]) most = std::max(most, std::abs(a[k] - b[k]) / (greatest[k] - least[k]));
        return most;
    }
    /// The bits of all coordinates in turn, highest first.
    std::uint64_t key(const RayStart& ray) const {
        if (!starts(ray)) return std::numeric_limits<std::uint64_t>::max();
        const Coordinates at = coordinates_of(ray);
        std::array<std::uint32_t, dimensions> cell{};
        for (std::size_t k = 0; k < dimensions; ++k) {
            const double size = greatest[k] - least[k];
            // Not a number where a momentum is none; the ray then fails wherever it stands.
            const double share = size > 0 ? (at[k] - least[k]) / size : 0;
            cell[k] = share > 0 ? static_cast<std::uint32_t>(std::min(share, 1.0) * ((1 << bits) - 1)) : 0;
        }
        std::uint64_t key = 0;
        for (int bit = bits - 1; bit >= 0; --bit)
            for (const std::uint32_t c : cell) key = key << 1 | (c >> bit & 1);
        return key;
    }
};

}  // namespace

bool neighbours_go_together(const std::vector<RayStart>& rays) {
    constexpr std::size_t looked_at = 1000;
    constexpr double near = 0.2;  // of the box; in no order, neighbours are half of it apart
    std::vector<std::array<Coordinates, 2>> pairs;
    Box box;
    for (std::size_t i = 0; i + 1 < rays.size(); i += 1 + rays.size() / looked_at) {
        if (!starts(rays[i]) || !starts(rays[i + 1])) continue;
        pairs.push_back({coordinates_of(rays[i]), coordinates_of(rays[i + 1])});
        for (const Coordinates& at : pairs.back()) box.add(at);
    }
    double sum = 0;
    for (const auto& [a, b] : pairs) sum += box.distance(a, b);
    return sum <= near * double(pairs.size());
}

std::vector<std::uint32_t> coherent_order(const std::vector<RayStart>& rays) {
    Box box;
    for (const RayStart& ray : rays)
        if (starts(ray)) box.add(coordinates_of(ray));
    std::vector<std::pair<std::uint64_t, std::uint32_t>> keys;
    keys.reserve(rays.size());
    for (std::uint32_t i = 0; i < rays.size(); ++i) keys.emplace_back(box.key(rays[i]), i);
    std::sort(keys.begin(), keys.end());
    std::vector<std::uint32_t> order;
    order.reserve(keys.size());
    for (const auto& [key, place] : keys) order.push_back(place);
    return order;
}

}  // namespace kagero

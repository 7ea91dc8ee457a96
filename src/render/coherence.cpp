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

    explicit Box(const std::vector<RayStart>& rays) {
        least.fill(std::numeric_limits<double>::infinity()), greatest.fill(-std::numeric_limits<double>::infinity());
        for (const RayStart& ray : rays) {
            if (!starts(ray)) continue;
            const Coordinates at = coordinates_of(ray);
            for (std::size_t k = 0; k < dimensions; ++k)
                least[k] = std::min(least[k], at[k]), greatest[k] = std::max(greatest[k], at[k]);
        }
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

std::vector<std::uint32_t> coherent_order(const std::vector<RayStart>& rays) {
    const Box box(rays);
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

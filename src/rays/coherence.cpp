#include "rays/coherence.h"

#include <boost/sort/spreadsort/integer_sort.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

namespace kagero {
namespace {

constexpr std::size_t dimensions = 6;  ///< position, unit direction
constexpr int most_bits = 10;          ///< of each

using Coordinates = std::array<double, dimensions>;

bool starts(const RayStart& ray) { return ray.failure == Failure::none && !ray.captured && !ray.escaped; }

Coordinates coordinates_of(const RayStart& ray) {
    const double inverse = 1 / std::sqrt(ray.p[0] * ray.p[0] + ray.p[1] * ray.p[1] + ray.p[2] * ray.p[2]);
    return {ray.q[0], ray.q[1], ray.q[2], ray.p[0] * inverse, ray.p[1] * inverse, ray.p[2] * inverse};
}

/// The smallest box around all rays; flat in the dimensions that they share.
struct Box {
    Coordinates least, greatest;

    Box() {
        least.fill(std::numeric_limits<double>::infinity()), greatest.fill(-std::numeric_limits<double>::infinity());
    }
    void add(const Coordinates& at) {
        for (std::size_t k = 0; k < dimensions; ++k)
            least[k] = std::min(least[k], at[k]), greatest[k] = std::max(greatest[k], at[k]);
    }
    /// The greatest distance along any dimension, as a share of the box.
    double distance(const Coordinates& a, const Coordinates& b) const {
        double most = 0;
        for (std::size_t k = 0; k < dimensions; ++k)
            if (greatest[k] > least[k]) most = std::max(most, std::abs(a[k] - b[k]) / (greatest[k] - least[k]));
        return most;
    }
    /// How many dimensions the rays differ in.
    std::size_t extent() const {
        std::size_t n = 0;
        for (std::size_t k = 0; k < dimensions; ++k) n += greatest[k] > least[k];
        return n;
    }
};

/// Orders places in a box so that neighbours stay near each other (Morton, 1966): the first `bits` bits of the
/// coordinates that differ, in turn, highest first.
class MortonCurve {
public:
    MortonCurve(const Box& box, int bits) : box_(box), cells_((1u << bits) - 1), spread_(std::size_t{cells_} + 1) {
        const std::size_t extent = box.extent();
        for (std::uint32_t cell = 0; cell <= cells_; ++cell)
            for (int bit = 0; bit < bits; ++bit)
                spread_[cell] |= std::uint64_t(cell >> bit & 1) << (std::size_t(bit) * extent);
    }
    std::uint64_t key(const Coordinates& at) const {
        std::uint64_t key = 0;
        for (std::size_t k = 0; k < dimensions; ++k) {
            const double size = box_.greatest[k] - box_.least[k];
            if (!(size > 0)) continue;
            // Not a number where a momentum is none; the ray then fails wherever it stands.
            const double share = (at[k] - box_.least[k]) / size;
            key = key << 1 | spread_[share > 0 ? static_cast<std::uint32_t>(std::min(share, 1.0) * cells_) : 0];
        }
        return key;
    }

private:
    const Box& box_;
    std::uint32_t cells_;
    std::vector<std::uint64_t> spread_;  ///< the bits of a cell's number, as far apart as there are coordinates
};

}  // namespace

bool neighbours_go_together(const std::vector<RayStart>& rays) {
    constexpr std::size_t looked_at = 200;
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
    std::vector<Coordinates> all;
    all.reserve(rays.size());
    Box box;
    for (const RayStart& ray : rays) {
        all.push_back(coordinates_of(ray));
        if (starts(ray)) box.add(all.back());
    }
    // Key and place in one number; rays that end where they start come last.
    const int place_bits = std::bit_width(rays.size());
    const int bits = std::min(most_bits, (63 - place_bits) / std::max(1, static_cast<int>(box.extent())));
    const MortonCurve curve(box, bits);
    std::vector<std::uint64_t> keys;
    keys.reserve(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i)
        keys.push_back((starts(rays[i]) ? curve.key(all[i]) : std::uint64_t(1) << (63 - place_bits)) << place_bits | i);
    boost::sort::spreadsort::integer_sort(keys.begin(), keys.end());
    std::vector<std::uint32_t> order;
    order.reserve(keys.size());
    for (const std::uint64_t key : keys)
        order.push_back(static_cast<std::uint32_t>(key & ((std::uint64_t(1) << place_bits) - 1)));
    return order;
}

}  // namespace kagero

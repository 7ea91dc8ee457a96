#include "rays/coherence.h"

#include <boost/sort/spreadsort/integer_sort.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

namespace kagero {
namespace {

constexpr std::size_t dimensions = 6;  ///< Position, and unit vector along the momentum.
constexpr int max_bits = 10;           ///< Maximum number of bits per dimension in a key.

using Coordinates = std::array<double, dimensions>;

/// Returns true if a ray is integrated; other rays end at their start.
bool is_integrated(const RayStart& ray) { return ray.failure == Failure::none && !ray.captured && !ray.escaped; }

Coordinates coordinates_of(const RayStart& ray) {
    const double inverse = 1 / std::sqrt(ray.p[0] * ray.p[0] + ray.p[1] * ray.p[1] + ray.p[2] * ray.p[2]);
    return {ray.q[0], ray.q[1], ray.q[2], ray.p[0] * inverse, ray.p[1] * inverse, ray.p[2] * inverse};
}

/// Smallest six-dimensional box that contains all coordinates that were passed to `include`.
struct Box {
    Coordinates least, greatest;  ///< Equal in dimensions in which the rays do not differ.

    Box() {
        least.fill(std::numeric_limits<double>::infinity());
        greatest.fill(-std::numeric_limits<double>::infinity());
    }
    void include(const Coordinates& at) {
        for (std::size_t k = 0; k < dimensions; ++k) {
            least[k] = std::min(least[k], at[k]);
            greatest[k] = std::max(greatest[k], at[k]);
        }
    }
    /// Returns the maximum, over the dimensions, of |a − b| divided by the extent of the box in that dimension.
    double distance(const Coordinates& a, const Coordinates& b) const {
        double greatest_distance = 0;
        for (std::size_t k = 0; k < dimensions; ++k)
            if (greatest[k] > least[k])
                greatest_distance = std::max(greatest_distance, std::abs(a[k] - b[k]) / (greatest[k] - least[k]));
        return greatest_distance;
    }
    /// Returns the number of dimensions in which the rays differ.
    std::size_t varying_dimensions() const {
        std::size_t n = 0;
        for (std::size_t k = 0; k < dimensions; ++k) n += greatest[k] > least[k];
        return n;
    }
};

/// Z-order curve through a box (Morton, 1966): points with similar keys are close together. Each dimension in which the
/// rays differ is divided into 2^bits cells, and a key interleaves the bits of the cell numbers.
class MortonCurve {
public:
    MortonCurve(const Box& box, int bits)
        : box_(box), last_cell_((1u << bits) - 1), spread_(std::size_t{last_cell_} + 1) {
        const std::size_t varying_dimensions = box.varying_dimensions();
        for (std::uint32_t cell = 0; cell <= last_cell_; ++cell)
            for (int bit = 0; bit < bits; ++bit)
                spread_[cell] |= std::uint64_t(cell >> bit & 1) << (std::size_t(bit) * varying_dimensions);
    }
    std::uint64_t key(const Coordinates& at) const {
        std::uint64_t key = 0;
        for (std::size_t k = 0; k < dimensions; ++k) {
            const double size = box_.greatest[k] - box_.least[k];
            if (!(size > 0)) continue;
            // NaN if the momentum is invalid. Such a ray fails, so its position in the order does not matter.
            const double fraction = (at[k] - box_.least[k]) / size;
            const double cell = fraction > 0 ? std::min(fraction, 1.0) * last_cell_ : 0;
            key = key << 1 | spread_[static_cast<std::uint32_t>(cell)];
        }
        return key;
    }

private:
    const Box& box_;
    std::uint32_t last_cell_;            ///< Greatest cell number.
    std::vector<std::uint64_t> spread_;  ///< For each cell: its number, with bit i moved to bit i · varying_dimensions.
};

}  // namespace

bool neighbours_are_coherent(const std::vector<RayStart>& rays) {
    constexpr std::size_t sample_size = 200;
    constexpr double max_mean_distance = 0.2;  // relative to the box; the mean is about 0.5 in a random order
    std::vector<std::array<Coordinates, 2>> pairs;
    Box box;
    for (std::size_t i = 0; i + 1 < rays.size(); i += 1 + rays.size() / sample_size) {
        if (!is_integrated(rays[i]) || !is_integrated(rays[i + 1])) continue;
        pairs.push_back({coordinates_of(rays[i]), coordinates_of(rays[i + 1])});
        for (const Coordinates& at : pairs.back()) box.include(at);
    }
    double sum = 0;
    for (const auto& [a, b] : pairs) sum += box.distance(a, b);
    return sum <= max_mean_distance * double(pairs.size());
}

std::vector<std::uint32_t> coherent_order(const std::vector<RayStart>& rays) {
    std::vector<Coordinates> coordinates;
    coordinates.reserve(rays.size());
    Box box;
    for (const RayStart& ray : rays) {
        coordinates.push_back(coordinates_of(ray));
        if (is_integrated(ray)) box.include(coordinates.back());
    }
    // Each sorted number contains the key of a ray in its upper bits and the index of the ray in its lower bits. Rays
    // that end at their start get the greatest key.
    const int index_bits = std::bit_width(rays.size());
    const int bits = std::min(max_bits, (63 - index_bits) / std::max(1, static_cast<int>(box.varying_dimensions())));
    const MortonCurve curve(box, bits);
    std::vector<std::uint64_t> keys_and_indices;
    keys_and_indices.reserve(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const std::uint64_t key =
            is_integrated(rays[i]) ? curve.key(coordinates[i]) : std::uint64_t(1) << (63 - index_bits);
        keys_and_indices.push_back(key << index_bits | i);
    }
    boost::sort::spreadsort::integer_sort(keys_and_indices.begin(), keys_and_indices.end());
    std::vector<std::uint32_t> order;
    order.reserve(rays.size());
    for (const std::uint64_t number : keys_and_indices)
        order.push_back(static_cast<std::uint32_t>(number & ((std::uint64_t(1) << index_bits) - 1)));
    return order;
}

}  // namespace kagero

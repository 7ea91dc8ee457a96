#include "appearance/packets/sky_lookup.h"

#include "kernels/assertion.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace kagero {
namespace sky_arrays {

constexpr std::uint32_t capacity = 64;  ///< Greatest number of blocks or rays in one call of the module.
static_assert(capacity % shading_lanes == 0);

using Numbers = std::array<double, capacity>;
using Vectors = std::array<Numbers, 3>;

inline std::uint32_t whole_vectors(std::uint32_t count) {
    return (count + shading_lanes - 1) / shading_lanes * shading_lanes;
}

inline void set(Vectors& vectors, std::uint32_t i, const Double3& v) {
    for (std::size_t k = 0; k < 3; ++k) vectors[k][i] = v[k];
}
inline Double3 get(const Vectors& vectors, std::uint32_t i) { return {vectors[0][i], vectors[1][i], vectors[2][i]}; }

/// Copies element 0 to the unused elements of the last vector, so that all its elements are finite.
inline void fill_last_vector(Vectors& vectors, std::uint32_t count) {
    for (Numbers& numbers : vectors)
        std::fill(numbers.begin() + count, numbers.begin() + whole_vectors(count), numbers[0]);
}

template <class Pointer, std::size_t n>
void point_to(Pointer (&pointers)[n], std::array<Numbers, n>& numbers) {
    for (std::size_t k = 0; k < n; ++k) pointers[k] = numbers[k].data();
}

inline void copy_axis(const Double3& axis, double (&to)[3]) { std::copy(axis.begin(), axis.end(), to); }

/// Up to `capacity` rays, or the rays in one place of their blocks, and the directions that the module reads.
struct RayArrays {
    Vectors direction;
    std::array<PixelSample*, capacity> rays;

    void set(std::uint32_t i, PixelSample& ray) {
        sky_arrays::set(direction, i, ray.sky.direction);
        rays[i] = &ray;
    }
};

/// What the module computes of points on a sky.
struct PointResults {
    Numbers u, v, level, probes, bend;
    std::array<Numbers, 2> by_major, by_minor;
};

}  // namespace sky_arrays

using namespace sky_arrays;

/// The rays that escape to one sky.
class SkyLookup::Collector {
public:
    Collector(const Module& module, const LoadedSky& sky, bool wants_footprints)
        : module_(module), sky_(sky), wants_footprints_(wants_footprints),
          is_plain_(!has_pattern(sky.paint) && !wants_footprints), plain_color_(plain_color(sky.paint.paint)) {
        copy_axis(sky.axes.zero, points_.zero);
        copy_axis(sky.axes.east, points_.east);
        copy_axis(sky.axes.up, points_.up);
        points_.texel = sky.paint.image ? texel_on_sphere(*sky.paint.image) : 0;
        points_.u = results_.u.data();
        points_.v = results_.v.data();
        points_.probes = results_.probes.data();
        points_.bend = results_.bend.data();
        point_to(points_.by_major, results_.by_major);
        point_to(points_.by_minor, results_.by_minor);
    }
    void add_block(std::span<PixelSample, 4> rays) {
        if (is_plain_) {
            for (PixelSample& ray : rays) ray.source_color = plain_color_;
            return;
        }
        for (std::size_t k = 0; k < 4; ++k) blocks_[k].set(block_count_, rays[k]);
        if (++block_count_ == capacity) finish_blocks();
    }
    void add(PixelSample& ray, const Footprint& footprint) {
        if (is_plain_) {
            ray.source_color = plain_color_;
            return;
        }
        singles_.set(single_count_, ray);
        set(single_major_, single_count_, footprint.major);
        set(single_minor_, single_count_, footprint.minor);
        if (++single_count_ == capacity) finish_singles();
    }
    void finish() {
        if (block_count_ > 0) finish_blocks();
        if (single_count_ > 0) finish_singles();
    }

private:
    void finish_blocks() {
        SkyBlocks blocks{whole_vectors(block_count_), {}, {}, {}};
        for (std::size_t k = 0; k < 4; ++k) {
            fill_last_vector(blocks_[k].direction, block_count_);
            point_to(blocks.directions[k], blocks_[k].direction);
        }
        point_to(blocks.major, block_major_);
        point_to(blocks.minor, block_minor_);
        module_.shading.sky_footprints(&blocks);
        bool has_probes = false;  // the rays of a block have the same probes
        for (RayArrays& rays : blocks_) {
            for (std::uint32_t i = 0; wants_footprints_ && i < block_count_; ++i)
                rays.rays[i]->footprint = {get(block_major_, i), get(block_minor_, i)};
            color(rays, block_major_, block_minor_, block_count_, std::exchange(has_probes, true));
        }
        block_count_ = 0;
    }
    void finish_singles() {
        for (Vectors* vectors : {&singles_.direction, &single_major_, &single_minor_})
            fill_last_vector(*vectors, single_count_);
        color(singles_, single_major_, single_minor_, single_count_, false);
        single_count_ = 0;
    }
    /// Sets the colours of the first `count` rays. If `has_probes` is true, `results_` contains their probes.
    void color(RayArrays& rays, Vectors& major, Vectors& minor, std::uint32_t count, bool has_probes) {
        if (!has_pattern(sky_.paint)) {
            for (std::uint32_t i = 0; i < count; ++i) rays.rays[i]->source_color = plain_color_;
            return;
        }
        points_.count = whole_vectors(count);
        point_to(points_.direction, rays.direction);
        point_to(points_.major, major);
        point_to(points_.minor, minor);
        points_.level = has_probes ? nullptr : results_.level.data();
        module_.shading.sky_points(&points_);
        points_.level = results_.level.data();
        if (sky_.paint.image) {
            std::array<Float3, capacity> colors;
            sky_texture_colors(*sky_.paint.image, *sky_.paint.coarser, module_, points_, {colors.data(), count});
            for (std::uint32_t i = 0; i < count; ++i) rays.rays[i]->source_color = colors[i];
            return;
        }
        const auto& [a, b] = std::tie(results_.by_major, results_.by_minor);
        for (std::uint32_t i = 0; i < count; ++i)
            rays.rays[i]->source_color = checker_color(sky_.paint.paint, results_.u[i], results_.v[i],
                                                       {{a[0][i], a[1][i]}, {b[0][i], b[1][i]}}, repeat_along_u);
    }

    const Module& module_;
    const LoadedSky& sky_;
    bool wants_footprints_;
    bool is_plain_;  ///< True if the colour is known without a lookup.
    Float3 plain_color_;
    std::uint32_t block_count_ = 0, single_count_ = 0;
    std::array<RayArrays, 4> blocks_;  ///< The rays by their place in the block.
    RayArrays singles_;
    Vectors block_major_, block_minor_, single_major_, single_minor_;
    PointResults results_;
    SkyPoints points_{};
};

SkyLookup::SkyLookup(const Module& module, const Paints& paints, bool wants_footprints)
    : module_(module), paints_(paints), wants_footprints_(wants_footprints) {}

SkyLookup::~SkyLookup() = default;

SkyLookup::Collector& SkyLookup::sky_of(const PixelSample& ray) {
    auto& collector = skies_[ray.sky.on_second_sheet];
    if (!collector)
        collector = std::make_unique<Collector>(module_, paints_.sky(ray.sky.on_second_sheet), wants_footprints_);
    return *collector;
}

void SkyLookup::add_block(std::span<PixelSample, 4> rays) { sky_of(rays[0]).add_block(rays); }

void SkyLookup::add(PixelSample& ray, const Footprint& footprint) { sky_of(ray).add(ray, footprint); }

void SkyLookup::finish() {
    for (const auto& sky : skies_)
        if (sky) sky->finish();
}

}  // namespace kagero

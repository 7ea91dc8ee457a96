/// Where rays come from: the pixels of a camera, or a list.
#pragma once

#include "kernels/abi.h"
#include "kernels/assertion.h"
#include "kernels/equations/state.h"
#include "kernels/simd/bits.h"

#include <cmath>
#include <cstddef>
#include <limits>

namespace kagero {

/// A bit for each of W lanes.
template <int W>
inline constexpr std::uint64_t all_lanes = W == 64 ? ~std::uint64_t(0) : (std::uint64_t(1) << W) - 1;

/// Rays that start together, a lane each.
template <int W>
struct RayStarts {
    alignas(64) double y[state_size][W];      ///< x y z px py pz pt
    std::uint64_t captured, escaped, failed;  ///< lanes, as RayStart states for one ray
    Failure failure[W];                       ///< of those that failed

    void put(int lane, const RayStart& ray) {
        for (int k = 0; k < space_size; ++k) y[k][lane] = ray.q[k], y[momentum(k)][lane] = ray.p[k];
        y[component_pt][lane] = ray.pt, failure[lane] = ray.failure;
        failed |= std::uint64_t(ray.failure != Failure::none) << lane;
        captured |= std::uint64_t(ray.captured) << lane, escaped |= std::uint64_t(ray.escaped) << lane;
    }
    /// Lanes that are not in `lanes` repeat one that is.
    void fill_up(std::uint64_t lanes) {
        KAGERO_ASSERT(lanes);
        const int donor = __builtin_ctzll(lanes);
        for (const int i : lanes_in(~lanes & all_lanes<W>))
            for (auto& numbers : y) numbers[i] = numbers[donor];
    }
};

/// Generates the rays through points (x[i], y[i]) of the film, in pixels; written for the compiler to vectorize.
template <int W>
void generate_camera_rays(const CameraRays& from, const double (&x)[W], const double (&y)[W], RayStarts<W>& rays) {
    const CameraRays c = from;  // a copy: no ray can alias it
    const StartMap& map = c.start;
    const double least_pt = map.pt > 0 ? 0 : std::numeric_limits<double>::infinity();
    for (int i = 0; i < W; ++i) {
        double d[3], p[4];
        for (int k = 0; k < 3; ++k) d[k] = c.corner[k] + x[i] * c.right[k] + y[i] * c.down[k];
        const auto row = [&](int k) {
            return map.metric[k][0] * d[0] + map.metric[k][1] * d[1] + map.metric[k][2] * d[2];
        };
        const double inverse = 1 / std::sqrt(d[0] * row(0) + d[1] * row(1) + d[2] * row(2));
        for (double& component : d) component *= inverse;
        for (int k = 0; k < 4; ++k)
            p[k] = map.matrix[k][0] * d[0] + map.matrix[k][1] * d[1] + map.matrix[k][2] * d[2] + map.offset[k];
        const double scale = p[3] > least_pt ? map.pt / p[3] : 1;
        for (int k = 0; k < space_size; ++k) rays.y[k][i] = c.position[k], rays.y[momentum(k)][i] = p[k] * scale;
        rays.y[component_pt][i] = p[3] * scale;
    }
    rays.captured = rays.escaped = rays.failed = 0;
    if (map.pt > 0 && map.sky_alone)
        for (int i = 0; i < W; ++i) rays.captured |= std::uint64_t(!(rays.y[component_pt][i] > 0)) << i;
}

/// The rays of a tile one after the other, by slots: every W of them are a packet, a block of pixels aligned to the
/// picture's grid (so that tiles and crops change no packet), a run of a row, or a run of a list. Slots may lie outside
/// of the tile.
template <int W>
class RayQueue {
public:
    RayQueue(const Job& job, const Tile& tile, RayEnd* ends)
        : job_(job), tile_(tile), ends_(ends), numbered_(!job.camera || job.path_sink),
          width_(job.camera && !job.scanlines ? block_width(W) : W), height_(W / width_), x_(tile.x0 / width_ * width_),
          y_(tile.y0 / height_ * height_) {
        for (std::uint32_t i = 0; i < W; ++i) {
            const std::uint32_t x = i % width_, y = i / width_;
            to_x_[i] = x + 0.5, to_y_[i] = y + 0.5, to_end_[i] = std::ptrdiff_t(y) * (tile.x1 - tile.x0) + x;
        }
    }

    bool empty() const { return y_ >= tile_.y1; }
    /// The rays of the next slots for the lanes of `free`, where their ends go, and, where anybody asks for them, their
    /// numbers; returns the lanes whose slot does not lie outside of the tile.
    std::uint64_t take(std::uint64_t free, RayStarts<W>& starts, RayEnd* (&ends)[W], std::uint64_t (&numbers)[W]) {
        KAGERO_ASSERT((free & ~all_lanes<W>) == 0);
        alignas(64) double middle_x[W], middle_y[W];
        std::uint64_t taken = 0;
        const std::uint32_t row_length = job_.camera ? job_.camera->width : 0, tile_width = tile_.x1 - tile_.x0;
        const auto put = [&](int lane, std::uint32_t x, std::uint32_t y) {
            ends[lane] = ends_ + std::size_t(y - tile_.y0) * tile_width + (x - tile_.x0);
            if (numbered_) numbers[lane] = std::uint64_t(y) * row_length + x;
            middle_x[lane] = x + 0.5, middle_y[lane] = y + 0.5;
        };
        if (free == all_lanes<W> && row_ == 0 && column_ == 0 && x_ >= tile_.x0 && y_ >= tile_.y0 &&
            x_ + width_ <= tile_.x1 && y_ + height_ <= tile_.y1) {
            const double x0 = x_, y0 = y_;
            RayEnd* const first = ends_ + std::size_t(y_ - tile_.y0) * tile_width + (x_ - tile_.x0);
            for (int i = 0; i < W; ++i)
                middle_x[i] = x0 + to_x_[i], middle_y[i] = y0 + to_y_[i], ends[i] = first + to_end_[i];
            if (numbered_)
                for (int i = 0; i < W; ++i)
                    numbers[i] = std::uint64_t(middle_y[i]) * row_length + std::uint64_t(middle_x[i]);
            next_block();
            taken = free;
        } else {
            for (int i = 0; i < W; ++i) middle_x[i] = middle_y[i] = 0;
            for (; free && !empty(); free &= free - 1) {
                const std::uint32_t x = x_ + column_, y = y_ + row_;
                if (++column_ == width_) column_ = 0, ++row_;
                if (row_ == height_) row_ = 0, next_block();
                if (x < tile_.x0 || x >= tile_.x1 || y < tile_.y0 || y >= tile_.y1) continue;
                taken |= free & -free;
                put(__builtin_ctzll(free), x, y);
            }
        }
        if (job_.camera) {
            generate_camera_rays(*job_.camera, middle_x, middle_y, starts);
        } else {
            starts.captured = starts.escaped = starts.failed = 0;
            for (const int i : lanes_in(taken)) starts.put(i, job_.rays[numbers[i]]);
        }
        return taken;
    }

private:
    void next_block() {
        x_ += width_;
        if (x_ >= tile_.x1) x_ = tile_.x0 / width_ * width_, y_ += height_;
    }

    const Job& job_;
    const Tile& tile_;
    RayEnd* ends_;
    bool numbered_;  ///< a list, or paths: it matters which ray is which
    std::uint32_t width_, height_, x_, y_, column_ = 0, row_ = 0;
    /// From a block's corner to the middle of each pixel, and from the end of its first ray to that of each.
    alignas(64) double to_x_[W], to_y_[W];
    std::ptrdiff_t to_end_[W];
};

}  // namespace kagero

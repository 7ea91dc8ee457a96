/// Sources of rays: the pixels of a camera, or a list of ray starts.
#pragma once

#include "kernels/abi.h"
#include "kernels/assertion.h"
#include "kernels/equations/state.h"
#include "kernels/simd/bits.h"

#include <cmath>
#include <cstddef>
#include <limits>

namespace kagero {

/// Mask of W lanes.
template <int W>
inline constexpr std::uint64_t all_lane_bits = W == 64 ? ~std::uint64_t(0) : (std::uint64_t(1) << W) - 1;

/// The starts of W rays, one for each lane.
template <int W>
struct RayStarts {
    alignas(64) double y[state_size][W];      ///< Components x y z px py pz pt.
    std::uint64_t captured, escaped, failed;  ///< Lanes whose RayStart states that the ray ends at its start.
    std::uint64_t ingoing;       ///< Lanes whose start is in ingoing coordinates.
    std::uint64_t on_surface;    ///< Lanes whose RayStart names the surface on which the ray starts.
    Failure failure[W];                       ///< Reasons for the lanes of `failed`.
    std::uint32_t surface[W], primitive[W];   ///< Named surfaces and triangles of the lanes of `on_surface`.

    /// Sets the start of one lane.
    void set(int lane, const RayStart& ray) {
        for (int k = 0; k < space_size; ++k) {
            y[k][lane] = ray.q[k];
            y[momentum(k)][lane] = ray.p[k];
        }
        y[component_pt][lane] = ray.pt;
        failure[lane] = ray.failure;
        failed |= std::uint64_t(ray.failure != Failure::none) << lane;
        captured |= std::uint64_t(ray.captured) << lane;
        escaped |= std::uint64_t(ray.escaped) << lane;
        ingoing |= std::uint64_t(ray.ingoing) << lane;
        on_surface |= std::uint64_t(ray.surface != no_surface) << lane;
        surface[lane] = ray.surface;
        primitive[lane] = ray.primitive;
    }
    /// Copies the start of one of `lanes` to all other lanes.
    void fill_idle_lanes(std::uint64_t lanes) {
        KAGERO_ASSERT(lanes);
        const int donor = __builtin_ctzll(lanes);
        for (const int i : lanes_in(~lanes & all_lane_bits<W>))
            for (auto& component : y) component[i] = component[donor];
    }
};

/// Generates the rays through the points (x[i], y[i]) of the film, in pixels. The loop is simple so that the compiler
/// vectorizes it.
template <int W>
void generate_camera_rays(const CameraRays& camera, const double (&x)[W], const double (&y)[W], RayStarts<W>& rays) {
    const CameraRays c = camera;  // a copy, so that writes to `rays` cannot alias it
    const StartMap& map = c.start;
    for (int i = 0; i < W; ++i) {
        double d[3], p[4];
        for (int k = 0; k < 3; ++k) d[k] = c.corner[k] + x[i] * c.right[k] + y[i] * c.down[k];
        const auto lowered = [&](int k) {  // Σ_j metric[k][j] d[j]
            return map.metric[k][0] * d[0] + map.metric[k][1] * d[1] + map.metric[k][2] * d[2];
        };
        const double inverse = 1 / std::sqrt(d[0] * lowered(0) + d[1] * lowered(1) + d[2] * lowered(2));
        for (double& component : d) component *= inverse;
        for (int k = 0; k < 4; ++k)
            p[k] = map.matrix[k][0] * d[0] + map.matrix[k][1] * d[1] + map.matrix[k][2] * d[2] + map.offset[k];
        const double scale = p[3] * map.pt > 0 ? map.pt / p[3] : 1;
        for (int k = 0; k < space_size; ++k) {
            rays.y[k][i] = map.position[k];
            rays.y[momentum(k)][i] = p[k] * scale;
        }
        rays.y[component_pt][i] = p[3] * scale;
    }
    rays.captured = rays.escaped = rays.failed = rays.on_surface = 0;
    rays.ingoing = map.ingoing ? all_lane_bits<W> : 0;
    if (map.pt != 0 && map.has_no_surfaces)
        for (int i = 0; i < W; ++i) rays.captured |= std::uint64_t(!(rays.y[component_pt][i] * map.pt > 0)) << i;
}

/// Assigns the rays of a tile to lanes. Each group of W slots is one packet: a block of pixels, a run of pixels in a
/// row, or a run of a list. Blocks are aligned to a grid over the whole picture, so that tiles and crops do not change
/// the packets. Some slots may therefore lie outside the tile; they contain no ray.
template <int W>
class RayQueue {
public:
    RayQueue(const Job& job, const Tile& tile, RayEnd* ends)
        : job_(job), tile_(tile), ends_(ends), needs_indices_(!job.camera || job.path_sink),
          width_(job.camera && !job.scanlines ? block_width(W) : W), height_(W / width_), x_(tile.x0 / width_ * width_),
          y_(tile.y0 / height_ * height_) {
        for (std::uint32_t i = 0; i < W; ++i) {
            const std::uint32_t x = i % width_, y = i / width_;
            offset_x_[i] = x + 0.5;
            offset_y_[i] = y + 0.5;
            end_offset_[i] = std::ptrdiff_t(y) * (tile.x1 - tile.x0) + x;
        }
    }

    /// Returns true if all rays of the tile have been assigned.
    bool empty() const { return y_ >= tile_.y1; }
    /// Assigns the next slots to the lanes of `free`. Sets their starts, the destinations of their ends, and, for lists
    /// and paths, their indices. Returns the lanes that have received a ray of the tile.
    std::uint64_t next_rays(std::uint64_t free, RayStarts<W>& starts, RayEnd* (&ends)[W],
                            std::uint64_t (&ray_indices)[W]) {
        KAGERO_ASSERT((free & ~all_lane_bits<W>) == 0);
        alignas(64) double center_x[W], center_y[W];
        std::uint64_t filled = 0;
        const std::uint32_t row_length = job_.camera ? job_.camera->width : 0, tile_width = tile_.x1 - tile_.x0;
        const auto set = [&](int lane, std::uint32_t x, std::uint32_t y) {
            ends[lane] = ends_ + std::size_t(y - tile_.y0) * tile_width + (x - tile_.x0);
            if (needs_indices_) ray_indices[lane] = std::uint64_t(y) * row_length + x;
            center_x[lane] = x + 0.5;
            center_y[lane] = y + 0.5;
        };
        if (free == all_lane_bits<W> && row_ == 0 && column_ == 0 && x_ >= tile_.x0 && y_ >= tile_.y0 &&
            x_ + width_ <= tile_.x1 && y_ + height_ <= tile_.y1) {
            const double x0 = x_, y0 = y_;
            RayEnd* const first = ends_ + std::size_t(y_ - tile_.y0) * tile_width + (x_ - tile_.x0);
            for (int i = 0; i < W; ++i) {
                center_x[i] = x0 + offset_x_[i];
                center_y[i] = y0 + offset_y_[i];
                ends[i] = first + end_offset_[i];
            }
            if (needs_indices_)
                for (int i = 0; i < W; ++i)
                    ray_indices[i] = std::uint64_t(center_y[i]) * row_length + std::uint64_t(center_x[i]);
            next_block();
            filled = free;
        } else {
            for (int i = 0; i < W; ++i) center_x[i] = center_y[i] = 0;
            for (; free && !empty(); free &= free - 1) {
                const std::uint32_t x = x_ + column_, y = y_ + row_;
                if (++column_ == width_) {
                    column_ = 0;
                    ++row_;
                }
                if (row_ == height_) {
                    row_ = 0;
                    next_block();
                }
                if (x < tile_.x0 || x >= tile_.x1 || y < tile_.y0 || y >= tile_.y1) continue;
                filled |= free & -free;
                set(__builtin_ctzll(free), x, y);
            }
        }
        if (job_.camera) {
            generate_camera_rays(*job_.camera, center_x, center_y, starts);
        } else {
            starts.captured = starts.escaped = starts.failed = starts.ingoing = starts.on_surface = 0;
            for (const int i : lanes_in(filled)) starts.set(i, job_.rays[ray_indices[i]]);
        }
        return filled;
    }

private:
    /// Moves to the next block of slots.
    void next_block() {
        x_ += width_;
        if (x_ >= tile_.x1) {
            x_ = tile_.x0 / width_ * width_;
            y_ += height_;
        }
    }

    const Job& job_;
    const Tile& tile_;
    RayEnd* ends_;
    bool needs_indices_;  ///< True for lists and paths, which require the indices of rays.
    std::uint32_t width_, height_;        ///< Size of a block of slots.
    std::uint32_t x_, y_;                 ///< Position of the current block on the picture, or in the list.
    std::uint32_t column_ = 0, row_ = 0;  ///< Position of the next slot in the current block.
    alignas(64) double offset_x_[W], offset_y_[W];  ///< Offsets from the corner of a block to the pixel centres.
    std::ptrdiff_t end_offset_[W];  ///< Offsets from the first ray end of a block to the ray ends of the lanes.
};

}  // namespace kagero

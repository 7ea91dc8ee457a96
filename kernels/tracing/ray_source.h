/// Where rays come from: the pixels of a camera, or a list.
#pragma once

#include "kernels/abi.h"

#include <cmath>
#include <limits>

namespace kagero {

/// Rays that start together, a lane each.
template <int W>
struct RayStarts {
    alignas(64) double y[7][W];  ///< x y z px py pz pt
    Failure failure[W];
    std::uint64_t captured, escaped;  ///< lanes as RayStart says of one ray

    void put(int lane, const RayStart& ray) {
        for (int k = 0; k < 3; ++k) y[k][lane] = ray.q[k], y[3 + k][lane] = ray.p[k];
        y[6][lane] = ray.pt, failure[lane] = ray.failure;
        captured |= std::uint64_t(ray.captured) << lane, escaped |= std::uint64_t(ray.escaped) << lane;
    }
    /// Lanes that are not of `lanes` follow one that is.
    void fill_up(std::uint64_t lanes) {
        const int donor = __builtin_ctzll(lanes);
        for (int i = 0; i < W; ++i)
            if (!((lanes >> i) & 1))
                for (auto& numbers : y) numbers[i] = numbers[donor];
    }
};

/// The rays through places (x[i], y[i]) of the film, in pixels; written for the compiler to vectorize.
template <int W>
void look(const CameraRays& from, const double (&x)[W], const double (&y)[W], RayStarts<W>& rays) {
    const CameraRays c = from;  // which no ray can be an alias of
    const StartMap& map = c.start;
    const double least_pt = map.unit_pt ? 0 : std::numeric_limits<double>::infinity();
    for (int i = 0; i < W; ++i) {
        double d[3], p[4];
        for (int k = 0; k < 3; ++k) d[k] = c.corner[k] + x[i] * c.right[k] + y[i] * c.down[k];
        const auto row = [&](int k) { return map.metric[k][0] * d[0] + map.metric[k][1] * d[1] + map.metric[k][2] * d[2]; };
        const double inverse = 1 / std::sqrt(d[0] * row(0) + d[1] * row(1) + d[2] * row(2));
        for (double& component : d) component *= inverse;
        for (int k = 0; k < 4; ++k) p[k] = map.matrix[k][0] * d[0] + map.matrix[k][1] * d[1] + map.matrix[k][2] * d[2] + map.offset[k];
        const double scale = p[3] > least_pt ? 1 / p[3] : 1;
        for (int k = 0; k < 3; ++k) rays.y[k][i] = c.position[k], rays.y[3 + k][i] = p[k] * scale;
        rays.y[6][i] = p[3] * scale;
    }
    rays.captured = rays.escaped = 0;
    for (Failure& failure : rays.failure) failure = Failure::none;
    // Inside an ergosphere light of p_t <= 0 cannot have come from outside: only a hole sends it.
    if (map.unit_pt)
        for (int i = 0; i < W; ++i) rays.captured |= std::uint64_t(!(rays.y[6][i] > 0)) << i;
}

/// The rays of a tile one after the other, by slots: every W of them are a packet, a block of pixels aligned to the picture's grid (so
/// that tiles and crops change no packet), a run of a row, or a run of a list. Slots may lie outside of the tile.
template <int W>
class RayQueue {
public:
    RayQueue(const Job& job, const Tile& tile, RayEnd* ends)
        : job_(job), tile_(tile), ends_(ends), width_(job.camera && !job.scanlines ? block_width : W), height_(W / width_),
          x_(tile.x0 / width_ * width_), y_(tile.y0 / height_ * height_) {}

    bool empty() const { return y_ >= tile_.y1; }
    /// The rays of the next slots for the lanes of `free`, where their ends go, and their numbers; returns the lanes whose slot does not lie
    /// outside of the tile.
    std::uint64_t take(std::uint64_t free, RayStarts<W>& starts, RayEnd* (&ends)[W], std::uint64_t (&numbers)[W]) {
        std::uint64_t taken = 0;
        alignas(64) double middle_x[W] = {}, middle_y[W] = {};
        starts.captured = starts.escaped = 0;
        for (; free && !empty(); free &= free - 1) {
            const int i = __builtin_ctzll(free);
            const std::uint32_t x = x_ + column_, y = y_ + row_;
            if (++column_ == width_) column_ = 0, ++row_;
            if (row_ == height_) {
                row_ = 0, x_ += width_;
                if (x_ >= tile_.x1) x_ = tile_.x0 / width_ * width_, y_ += height_;
            }
            if (x < tile_.x0 || x >= tile_.x1 || y < tile_.y0 || y >= tile_.y1) continue;
            taken |= std::uint64_t(1) << i;
            ends[i] = ends_ + std::size_t(y - tile_.y0) * (tile_.x1 - tile_.x0) + (x - tile_.x0);
            numbers[i] = job_.camera ? std::uint64_t(y) * job_.camera->width + x : x;
            if (job_.camera) middle_x[i] = x + 0.5, middle_y[i] = y + 0.5;
            else starts.put(i, job_.rays[x]);
        }
        if (job_.camera) look(*job_.camera, middle_x, middle_y, starts);
        return taken;
    }

private:
    static constexpr std::uint32_t block_width = W >= 64 ? 8 : W >= 8 ? 4 : W >= 4 ? 2 : W;

    const Job& job_;
    const Tile& tile_;
    RayEnd* ends_;
    std::uint32_t width_, height_, x_, y_, column_ = 0, row_ = 0;
};

}  // namespace kagero

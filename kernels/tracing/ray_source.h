/// Where rays come from: the pixels of a camera, or a list.
#pragma once

#include "kernels/abi.h"

#include <cmath>

namespace kagero {

/// Canonical state seen by an observer in direction d of its rest frame (any length).
inline RayStart start_from_map(const StartMap& map, const double (&q)[3], double dx, double dy, double dz) {
    const auto row = [&](int i) { return map.metric[i][0] * dx + map.metric[i][1] * dy + map.metric[i][2] * dz; };
    const double inverse = 1 / std::sqrt(dx * row(0) + dy * row(1) + dz * row(2));
    const double d[3] = {dx * inverse, dy * inverse, dz * inverse};
    double p[4];
    for (int i = 0; i < 4; ++i) p[i] = map.matrix[i][0] * d[0] + map.matrix[i][1] * d[1] + map.matrix[i][2] * d[2] + map.offset[i];
    // Inside an ergosphere light of p_t <= 0 cannot have come from outside: only a hole sends it.
    const bool captured = map.unit_pt && !(p[3] > 0);
    const double scale = map.unit_pt && !captured ? 1 / p[3] : 1;
    return {{q[0], q[1], q[2]}, {p[0] * scale, p[1] * scale, p[2] * scale}, p[3] * scale, Failure::none, captured, false};
}

/// The ray through the middle of pixel (x, y).
inline RayStart camera_ray(const CameraRays& c, std::uint32_t x, std::uint32_t y) {
    const double u = x + 0.5, v = y + 0.5;
    double d[3];
    for (int k = 0; k < 3; ++k) d[k] = c.corner[k] + u * c.right[k] + v * c.down[k];
    return start_from_map(c.start, c.position, d[0], d[1], d[2]);
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
    /// The ray of the next slot, where its end goes, and its number; false where the slot lies outside of the tile.
    bool take(RayStart& start, RayEnd*& end, std::uint64_t& number) {
        const std::uint32_t x = x_ + slot_ % width_, y = y_ + slot_ / width_;
        if (++slot_ == W) {
            slot_ = 0, x_ += width_;
            if (x_ >= tile_.x1) x_ = tile_.x0 / width_ * width_, y_ += height_;
        }
        if (x < tile_.x0 || x >= tile_.x1 || y < tile_.y0 || y >= tile_.y1) return false;
        start = job_.camera ? camera_ray(*job_.camera, x, y) : job_.rays[x];
        end = ends_ + std::size_t(y - tile_.y0) * (tile_.x1 - tile_.x0) + (x - tile_.x0);
        number = job_.camera ? std::uint64_t(y) * job_.camera->width + x : x;
        return true;
    }

private:
    static constexpr std::uint32_t block_width = W >= 64 ? 8 : W >= 8 ? 4 : W >= 4 ? 2 : W;

    const Job& job_;
    const Tile& tile_;
    RayEnd* ends_;
    std::uint32_t width_, height_, x_, y_, slot_ = 0;
};

}  // namespace kagero

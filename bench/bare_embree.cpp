#include "bench/bare_embree.h"

#include "kernels/tracing/ray_source.h"
#include "kernels/tracing/segment_query.h"

#include <algorithm>
#include <cmath>

namespace kagero::bench {

void bare_embree(const CameraRays& camera, const Geometry& geometry, double escape_radius, const Tile& tile, RayEnd* ends) {
    constexpr int W = 16;
    constexpr std::uint32_t side = 4;
    const double length = 2 * escape_radius;
    const std::uint32_t width = tile.x1 - tile.x0;
    for (std::uint32_t by = tile.y0; by < tile.y1; by += side)
        for (std::uint32_t bx = tile.x0; bx < tile.x1; bx += side) {
            Segments<W> segments{};
            std::uint64_t active = 0;
            RayEnd* end[W];
            for (int i = 0; i < W; ++i) {
                const std::uint32_t x = bx + i % side, y = by + i / side;
                if (x >= tile.x1 || y >= tile.y1) continue;
                active |= std::uint64_t(1) << i;
                end[i] = ends + std::size_t(y - tile.y0) * width + (x - tile.x0);
                const RayStart ray = camera_ray(camera, x, y);
                const double inverse = 1 / std::sqrt(ray.p[0] * ray.p[0] + ray.p[1] * ray.p[1] + ray.p[2] * ray.p[2]);
                *end[i] = {};
                for (int k = 0; k < 3; ++k) {
                    end[i]->p[k] = ray.p[k], end[i]->v[k] = ray.p[k] * inverse;
                    end[i]->q[k] = ray.q[k] + length * end[i]->v[k];
                    segments.org[k][i] = float((ray.q[k] - geometry.shift[k]) * geometry.scale);
                    segments.dir[k][i] = float(end[i]->v[k] * length * geometry.scale);
                }
                end[i]->pt = ray.pt, end[i]->status = Status::escaped;
            }
            for (std::uint64_t hits = query(geometry.embree_scene, segments, active); hits; hits &= hits - 1) {
                const int i = __builtin_ctzll(hits);
                RayEnd& e = *end[i];
                for (int k = 0; k < 3; ++k) e.q[k] -= (1 - double(segments.t[i])) * length * e.v[k];
                e.status = Status::hit, e.surface = segments.surface[i], e.primitive = segments.primitive[i];
            }
        }
}

}  // namespace kagero::bench

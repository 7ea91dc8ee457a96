#include "bench/bare_embree.h"

#include "kernels/trace/ray_source.h"
#include "kernels/intersection/segment_query.h"

#include <algorithm>
#include <cmath>

namespace kagero::bench {

void bare_embree(const CameraRays& camera, const Geometry& geometry, double escape_radius, const Tile& tile,
                 RayEnd* ends) {
    constexpr int W = 16;               // rays per packet
    constexpr std::uint32_t side = 4;  // edge of a packet, in pixels
    const auto length = static_cast<float>(2 * escape_radius);  // kagero also renders this picture in float.
    const auto scale = static_cast<float>(geometry.scale);
    const std::uint32_t width = tile.x1 - tile.x0;
    for (std::uint32_t by = tile.y0; by < tile.y1; by += side)
        for (std::uint32_t bx = tile.x0; bx < tile.x1; bx += side) {
            Segments<W> segments{};
            double x[W], y[W];
            for (int i = 0; i < W; ++i) {
                x[i] = bx + i % side + 0.5;
                y[i] = by + i / side + 0.5;
            }
            RayStarts<W> rays;
            generate_camera_rays(camera, x, y, rays);
            std::uint64_t active = 0;
            RayEnd* end[W];
            for (int i = 0; i < W; ++i) {
                const std::uint32_t column = bx + i % side, row = by + i / side;
                if (column >= tile.x1 || row >= tile.y1) continue;
                active |= std::uint64_t(1) << i;
                RayEnd& e = *(end[i] = ends + std::size_t(row - tile.y0) * width + (column - tile.x0));
                e = {};
                float q[3], p[3];
                for (int k = 0; k < 3; ++k) {
                    q[k] = float(rays.y[k][i]);
                    p[k] = float(rays.y[3 + k][i]);
                }
                const float inverse = 1 / std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
                for (int k = 0; k < 3; ++k) {
                    const float v = p[k] * inverse;
                    segments.org[k][i] = (q[k] - float(geometry.shift[k])) * scale;
                    segments.dir[k][i] = v * length * scale;
                    e.v[k] = v;
                    e.p[k] = p[k];
                    e.q[k] = q[k] + length * v;
                }
                e.pt = rays.y[6][i];
                e.status = Status::escaped;
            }
            for (std::uint64_t hits = query(geometry.embree_scene, segments, active); hits; hits &= hits - 1) {
                const int i = __builtin_ctzll(hits);
                RayEnd& e = *end[i];
                for (int k = 0; k < 3; ++k) e.q[k] -= (1 - segments.t[i]) * length * float(e.v[k]);
                e.status = Status::hit;
                e.surface = segments.surface[i];
                e.primitive = segments.primitive[i];
            }
        }
}

}  // namespace kagero::bench

#include "render/schedule.h"

#include "kernels/assertion.h"

#include <algorithm>
#include <numeric>

namespace kagero {
namespace {

/// Greatest number of rays of a tile. Their ends take a few megabytes per thread.
constexpr std::uint64_t max_rays_per_tile = 32768;
/// Greatest width and height of a packet, in pixels.
constexpr std::uint32_t max_packet_edge = 8;

/// Returns the edge of a square tile, in pixels. It is shorter for many rays per pixel. It is even, because footprints
/// and patches need blocks of 2 × 2 pixels.
std::uint32_t tile_edge(std::uint32_t rays_per_pixel) {
    std::uint32_t edge = 32;
    while (edge > 2 && std::uint64_t{edge} * edge * rays_per_pixel > max_rays_per_tile) edge /= 2;
    return edge;
}

/// Bounds from which the prediction of costs is worthwhile. It costs a fiftieth of a picture with one ray per pixel.
/// With few tiles per thread, it shortens the time at the end of the run in which threads are idle. With many rays per
/// pixel, it makes the remaining time predictable.
constexpr std::uint32_t many_rays_per_pixel = 4;
constexpr std::uint64_t many_tiles_per_thread = 64;

/// Size of a tile, in pixels.
struct TileSize {
    std::uint32_t width, height;
};

TileSize tile_size(const Plan& plan, Schedule schedule) {
    const std::uint32_t spp = plan.description().film.spp, edge = tile_edge(spp);
    if (schedule != Schedule::scanline) return {edge, edge};
    const std::uint32_t height = std::min(edge, max_packet_edge);
    const std::uint64_t width = max_rays_per_tile / (std::uint64_t{height} * spp) / edge * edge;
    return {static_cast<std::uint32_t>(std::max<std::uint64_t>(width, edge)), height};
}

bool worth_predicting(const Plan& plan) {
    if (plan.scene->straight) return false;
    const std::uint32_t spp = plan.description().film.spp, edge = tile_edge(spp);
    const Tile& w = plan.view.window;
    const std::uint64_t tiles = std::uint64_t{w.x1 - w.x0} * (w.y1 - w.y0) / (std::uint64_t{edge} * edge);
    return spp >= many_rays_per_pixel || (plan.run.threads > 1 && tiles < many_tiles_per_thread * plan.run.threads);
}

}  // namespace

Schedule schedule_of(const Plan& plan) {
    return plan.run.schedule.value_or(worth_predicting(plan) ? Schedule::predicted : Schedule::tiles);
}

WorkList split_into_tiles(const Plan& plan, const Tile& w, Schedule schedule) {
    const auto [width, height] = tile_size(plan, schedule);
    KAGERO_ASSERT(w.x0 < w.x1 && w.y0 < w.y1 && width > 0 && height > 0);
    WorkList work;
    for (std::uint32_t y = w.y0 / height * height; y < w.y1; y += height)
        for (std::uint32_t x = w.x0 / width * width; x < w.x1; x += width) {
            const Tile& t = work.tiles.emplace_back(
                Tile{std::max(x, w.x0), std::max(y, w.y0), std::min(x + width, w.x1), std::min(y + height, w.y1)});
            work.costs.push_back(double(t.x1 - t.x0) * double(t.y1 - t.y0) * plan.description().film.spp);
        }
    return work;
}

void sort_by_descending_cost(WorkList& work) {
    std::vector<std::size_t> order(work.tiles.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return work.costs[a] > work.costs[b]; });
    WorkList sorted;
    for (const std::size_t i : order) {
        sorted.tiles.push_back(work.tiles[i]);
        sorted.costs.push_back(work.costs[i]);
    }
    work = std::move(sorted);
}

}  // namespace kagero

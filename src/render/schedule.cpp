#include "render/schedule.h"

#include "adaptive/sample_tile.h"
#include "kernels/assertion.h"

#include <algorithm>
#include <numeric>

namespace kagero {
namespace {

/// Greatest number of rays of a tile. Their ends take a few megabytes per thread.
constexpr std::uint64_t max_rays_per_tile = 32768;
/// Greatest width and height of a packet, in pixels.
constexpr std::uint32_t max_packet_edge = 8;

/// Returns the edge of a square tile, in pixels: at most 32, and less if the tile would have too many rays. The edge is
/// even, because footprints and patches need blocks of 2 × 2 pixels.
std::uint32_t tile_edge(std::uint32_t rays_per_pixel) {
    std::uint32_t edge = 32;
    while (edge > 2 && std::uint64_t{edge} * edge * rays_per_pixel > max_rays_per_tile) edge /= 2;
    return edge;
}

/// The prediction of costs is worthwhile with at least `many_rays_per_pixel` rays per pixel, because it makes the
/// remaining time predictable. It is also worthwhile with fewer than `many_tiles_per_thread` tiles per thread, because
/// it shortens the time at the end of the run in which threads are idle. The prediction takes a fiftieth of the time of
/// a picture with one ray per pixel.
constexpr std::uint32_t many_rays_per_pixel = 4;
constexpr std::uint64_t many_tiles_per_thread = 64;

/// Size of a tile, in pixels.
struct TileSize {
    std::uint32_t width, height;
};

TileSize tile_size(const Plan& plan, Schedule schedule) {
    if (plan.run.interpolation_bound > 0) return {adaptive_tile_edge, adaptive_tile_edge};
    const std::uint32_t spp = plan.description().film.spp, edge = tile_edge(spp);
    if (schedule != Schedule::scanline) return {edge, edge};
    const std::uint32_t height = std::min(edge, max_packet_edge);
    const std::uint64_t width = max_rays_per_tile / (std::uint64_t{height} * spp) / edge * edge;
    return {static_cast<std::uint32_t>(std::max<std::uint64_t>(width, edge)), height};
}

bool is_prediction_worthwhile(const Plan& plan) {
    if (plan.scene->straight || plan.run.interpolation_bound > 0) return false;
    const std::uint32_t spp = plan.description().film.spp, edge = tile_edge(spp);
    const Tile& window = plan.view.window;
    const std::uint64_t pixels = std::uint64_t{window.x1 - window.x0} * (window.y1 - window.y0);
    const std::uint64_t tiles = pixels / (std::uint64_t{edge} * edge);
    return spp >= many_rays_per_pixel || (plan.run.threads > 1 && tiles < many_tiles_per_thread * plan.run.threads);
}

}  // namespace

Schedule schedule_of(const Plan& plan) {
    return plan.run.schedule.value_or(is_prediction_worthwhile(plan) ? Schedule::predicted : Schedule::tiles);
}

std::uint64_t TileGrid::columns() const {
    return (window.x1 - 1) / width - window.x0 / width + 1;
}

std::uint64_t TileGrid::count() const {
    return columns() * ((window.y1 - 1) / height - window.y0 / height + 1);
}

Tile TileGrid::tile(std::uint64_t index) const {
    const auto x = static_cast<std::uint32_t>((window.x0 / width + index % columns()) * width);
    const auto y = static_cast<std::uint32_t>((window.y0 / height + index / columns()) * height);
    return {std::max(x, window.x0), std::max(y, window.y0), std::min(x + width, window.x1),
            std::min(y + height, window.y1)};
}

std::uint64_t TileGrid::index_of(const Tile& tile) const {
    return (tile.y0 / height - window.y0 / height) * columns() + (tile.x0 / width - window.x0 / width);
}

TileGrid tile_grid(const Plan& plan, const Tile& window, Schedule schedule) {
    const auto [width, height] = tile_size(plan, schedule);
    KAGERO_ASSERT(window.x0 < window.x1 && window.y0 < window.y1 && width > 0 && height > 0);
    return {window, width, height};
}

WorkList split_into_tiles(const Plan& plan, const TileGrid& grid) {
    WorkList work;
    for (std::uint64_t i = 0; i < grid.count(); ++i) {
        const Tile& t = work.tiles.emplace_back(grid.tile(i));
        work.costs.push_back(double(t.x1 - t.x0) * double(t.y1 - t.y0) * plan.description().film.spp);
    }
    return work;
}

WorkList split_into_tiles(const Plan& plan, const Tile& window, Schedule schedule) {
    return split_into_tiles(plan, tile_grid(plan, window, schedule));
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

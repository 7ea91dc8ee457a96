#include "render/schedule.h"

#include "kernels/assertion.h"

#include <algorithm>
#include <numeric>

namespace kagero {
namespace {

/// Rays that a thread holds at a time: some megabytes.
constexpr std::uint64_t most_rays = 32768;
/// No packet is higher, nor wider.
constexpr std::uint32_t packet_edge = 8;

/// Pixels along a square tile's edge: fewer where each has many rays; an even number, because footprints and patches
/// want blocks of 2 × 2.
std::uint32_t tile_edge(std::uint32_t rays_per_pixel) {
    std::uint32_t edge = 32;
    while (edge > 2 && std::uint64_t{edge} * edge * rays_per_pixel > most_rays) edge /= 2;
    return edge;
}

/// The first pass costs as much as a fiftieth of a picture of one ray per pixel. It is worth that where the last tiles
/// would keep other threads idle for as long, and where there are rays enough for the time left to be asked for.
constexpr std::uint32_t many_rays_per_pixel = 4;
constexpr std::uint64_t many_tiles_per_thread = 64;

struct Piece {
    std::uint32_t width, height;
};

Piece piece_of(const Plan& plan, Schedule schedule) {
    const std::uint32_t spp = plan.description().film.spp, edge = tile_edge(spp);
    if (schedule != Schedule::scanline) return {edge, edge};
    const std::uint32_t height = std::min(edge, packet_edge);
    const std::uint64_t width = most_rays / (std::uint64_t{height} * spp) / edge * edge;
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

WorkList cut(const Plan& plan, const Tile& w, Schedule schedule) {
    const auto [width, height] = piece_of(plan, schedule);
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

void put_costliest_first(WorkList& work) {
    std::vector<std::size_t> order(work.tiles.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return work.costs[a] > work.costs[b]; });
    WorkList sorted;
    for (const std::size_t i : order) sorted.tiles.push_back(work.tiles[i]), sorted.costs.push_back(work.costs[i]);
    work = std::move(sorted);
}

}  // namespace kagero

#include "render/render.h"

#include "render/run.h"
#include "render/sampler.h"
#include "render/shade.h"

namespace kagero {
namespace {

/// Rays of the crop, or of the whole film.
Tile window(const Plan& plan) {
    const auto& c = plan.options.crop;
    if (c[2] == 0) return {0, 0, plan.scene.film.width, plan.scene.film.height};
    return {c[0], c[1], c[2], c[3]};
}

/// The window cut at multiples of the tile's edge, so that a crop traces the same packets as the whole picture.
std::vector<Tile> cut(const Tile& w, std::uint32_t edge) {
    std::vector<Tile> tiles;
    for (std::uint32_t y = w.y0 / edge * edge; y < w.y1; y += edge)
        for (std::uint32_t x = w.x0 / edge * edge; x < w.x1; x += edge)
            tiles.push_back({std::max(x, w.x0), std::max(y, w.y0), std::min(x + edge, w.x1), std::min(y + edge, w.y1)});
    return tiles;
}

/// Pixels along a tile's edge: fewer where each has many rays, so that a tile's rays stay within some megabytes.
std::uint32_t tile_edge(std::uint32_t rays_per_pixel) {
    std::uint32_t edge = 32;
    while (edge > 1 && std::uint64_t{edge} * edge * rays_per_pixel > 32768) edge /= 2;
    return edge;
}

/// All rays of a tile, pixel by pixel.
void list_rays(const Plan& plan, const Tile& tile, RayList& list) {
    const FilmDescription& film = plan.scene.film;
    list.starts.clear(), list.frequencies.clear();
    for (std::uint32_t y = tile.y0; y < tile.y1; ++y)
        for (std::uint32_t x = tile.x0; x < tile.x1; ++x)
            for (std::uint32_t i = 0; i < film.spp; ++i) {
                const auto [u, v] = place_in_pixel(x, y, i, film.spp, film.seed);
                const CameraRay ray = camera_ray(plan, x + u, y + v);
                list.starts.push_back(ray.start), list.frequencies.push_back(ray.frequency);
            }
}

/// The rays of a pixel, the first of them `first` in the tile.
void gather(const Plan& plan, const RayEnd* ends, const RayList& list, std::size_t first, std::uint32_t x, std::uint32_t y,
            std::vector<Sighting>& pixel) {
    if (kernel_makes_rays(plan)) {
        pixel[0] = {ends + first, camera_ray(plan, x + 0.5, y + 0.5)};
        return;
    }
    for (std::size_t i = 0; i < pixel.size(); ++i)
        pixel[i] = {ends + first + i, {list.starts[first + i], list.frequencies[first + i]}};
}

}  // namespace

RunReport render(const Plan& plan, Film& film, const Progress& progress, const std::atomic<bool>* stop) {
    Job job = plan.job;
    if (film.has("energy_error")) job.outputs |= output_energy;
    const Tile whole = window(plan);
    const std::uint32_t spp = plan.scene.film.spp;
    TileRays rays;
    if (!kernel_makes_rays(plan)) rays = [&](const Tile& tile, RayList& list) { list_rays(plan, tile, list); };
    const auto done = [&](const Tile& tile, const RayEnd* ends, const RayList& list) {
        std::vector<Sighting> pixel(spp);
        std::size_t first = 0;
        for (std::uint32_t y = tile.y0; y < tile.y1; ++y)
            for (std::uint32_t x = tile.x0; x < tile.x1; ++x, first += spp) {
                gather(plan, ends, list, first, x, y, pixel);
                shade(plan, pixel, film, x - whole.x0, y - whole.y0);
            }
    };
    return run_tiles(plan, job, cut(whole, tile_edge(spp)), rays, done, progress, stop);
}

}  // namespace kagero

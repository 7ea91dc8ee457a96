#include "render/render.h"

#include "render/run.h"
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

constexpr std::uint32_t tile_edge = 32;

}  // namespace

RunReport render(const Plan& plan, Film& film, const Progress& progress, const std::atomic<bool>* stop) {
    Job job = plan.job;
    if (film.has("energy_error")) job.outputs |= output_energy;
    const Tile whole = window(plan);
    return run_tiles(plan, job, cut(whole, tile_edge), [&](const Tile& tile, const RayEnd* ends) {
        const std::uint32_t width = tile.x1 - tile.x0;
        for (std::uint32_t y = tile.y0; y < tile.y1; ++y)
            for (std::uint32_t x = tile.x0; x < tile.x1; ++x)
                shade(plan, ends[std::size_t(y - tile.y0) * width + (x - tile.x0)], film, x - whole.x0, y - whole.y0);
    }, progress, stop);
}

}  // namespace kagero

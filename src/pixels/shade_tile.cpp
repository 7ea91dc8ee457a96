#include "pixels/shade_tile.h"

#include "kernels/assertion.h"
#include "rays/sampler.h"

#include <algorithm>

namespace kagero {
namespace {

/// What shading has to know of rays beside their ends; what is not wanted is left empty.
struct Wanted {
    bool starts, footprints, patches;

    Wanted(const Plan& plan, const Film& film)
        : starts(needs_of(film) & need_start), footprints(wants_footprints(plan, film)),
          patches(plan.scene->paints->surfaces_have_patterns()) {
        for (const ObjectDescription& object : plan.description().objects)
            starts = starts || object.shape == Shape::disk;
    }
};

/// A tile's rays, and what is known of them.
struct TracedTile {
    const Plan& plan;
    const Tile& tile;
    const RayEnd* ends;
    const RayList& list;
    const std::vector<EndError>& errors;
};

/// Sets the rays of a row of pixels, from (x, y) on, as `rays`, which follow each other in the tile too. Of what they
/// were before, patches and skies are left that nobody asks of them now.
void gather(const TracedTile& traced, const Wanted& wanted, std::uint32_t x, std::uint32_t y, PixelBlock& block,
            std::span<PixelSample> rays) {
    const auto& [plan, tile, ends, list, errors] = traced;
    const std::uint32_t spp = plan.description().film.spp;
    const std::size_t first = (std::size_t(y - tile.y0) * (tile.x1 - tile.x0) + (x - tile.x0)) * spp;
    for (std::size_t k = 0; k < rays.size(); ++k) {
        PixelSample& ray = rays[k];
        const std::size_t i = first + k;
        ray.end = ends + i;
        if (ray.end->status == Status::escaped) ray.sky = sky_view(plan.scene->space, *ray.end);
        if (!errors.empty()) ray.error = &errors[i];
        if (wanted.starts) {
            const bool listed = !list.starts.empty();
            block.starts.push_back(listed ? CameraRay{list.starts[i], list.frequencies[i]}
                                          : camera_ray(plan, x + double(k / spp) + 0.5, y + 0.5));
            ray.ray = &block.starts.back();
        }
    }
}

void list_places(const FilmDescription& film, const Tile& pixels, PixelBlock& block) {
    block.places.clear();
    for (std::uint32_t y = pixels.y0; y < pixels.y1; ++y)
        for (std::uint32_t x = pixels.x0; x < pixels.x1; ++x)
            for (std::uint32_t i = 0; i < film.spp; ++i) {
                const auto [u, v] = film.spp == 1 ? std::array{0.5, 0.5} : place_in_pixel(x, y, i, film.spp, film.seed);
                block.places.push_back({x + u, y + v});
            }
}

Tile common(const Tile& a, const Tile& b) {
    return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}

}  // namespace

bool wants_footprints(const Plan& plan, const Film& film) {
    return plan.scene->paints->sky_has_pattern() || (needs_of(film) & need_footprint);
}

void shade_tile(const Plan& plan, const Tile& tile, const Tile& shown, const RayEnd* ends, const RayList& list,
                const std::vector<EndError>& errors, Film& film) {
    KAGERO_ASSERT(shown.x1 - shown.x0 == film.width() && shown.y1 - shown.y0 == film.height());
    KAGERO_ASSERT(list.starts.empty() || list.frequencies.size() == list.starts.size());
    const Wanted wanted(plan, film);
    const Shader shader(film);
    const TracedTile traced{plan, tile, ends, list, errors};
    const std::uint32_t spp = plan.description().film.spp;
    PixelBlock block;
    SkyFootprints footprints;
    block.starts.reserve(4 * std::size_t(spp));
    for (std::uint32_t by = tile.y0 & ~1u; by < tile.y1; by += 2)
        for (std::uint32_t bx = tile.x0 & ~1u; bx < tile.x1; bx += 2) {
            const Tile pixels = common({bx, by, bx + 2, by + 2}, tile), part = common(pixels, shown);
            const std::size_t row = std::size_t{pixels.x1 - pixels.x0} * spp;
            block.rays.resize(row * (pixels.y1 - pixels.y0)), block.starts.clear();
            const auto rays_from = [&](std::uint32_t x, std::uint32_t y) {
                return block.rays.data() + (y - pixels.y0) * row + (x - pixels.x0) * spp;
            };
            for (std::uint32_t y = pixels.y0; y < pixels.y1; ++y)
                gather(traced, wanted, pixels.x0, y, block, {rays_from(pixels.x0, y), row});
            const bool wants_patches = wanted.patches && !find_common_patch(*plan.scene->geometry, block, spp);
            if (wants_patches || wanted.footprints) list_places(plan.description().film, pixels, block);
            if (wants_patches) find_patches(*plan.scene->geometry, block, spp);
            if (wanted.footprints) footprints = footprints_of(block, spp);
            for (std::uint32_t y = part.y0; y < part.y1; ++y)
                for (std::uint32_t x = part.x0; x < part.x1; ++x)
                    shader.shade({plan, {rays_from(x, y), spp}, footprints, x, y}, x - shown.x0, y - shown.y0);
        }
}

}  // namespace kagero

#include "render/shade_tile.h"

#include "render/footprint.h"
#include "render/sampler.h"
#include "render/shade.h"

#include <algorithm>

namespace kagero {
namespace {

/// What shading has to know of rays beside their ends; what is not wanted is left empty.
struct Wanted {
    bool starts, footprints, patches;

    Wanted(const Plan& plan, const Film& film)
        : starts(needs_of(film) & need_start), footprints(wants_footprints(plan, film)), patches(plan.geometry->surfaces_have_patterns()) {
        for (const ObjectDescription& object : plan.scene.objects) starts = starts || object.shape == Shape::disk;
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

/// Sets the rays of pixel (x, y) as `rays`. Of what they were before, patches and skies are left that nobody asks of them now.
void gather(const TracedTile& traced, const Wanted& wanted, std::uint32_t x, std::uint32_t y, PixelBlock& block, std::span<Sighting> rays) {
    const auto& [plan, tile, ends, list, errors] = traced;
    std::size_t i = (std::size_t(y - tile.y0) * (tile.x1 - tile.x0) + (x - tile.x0)) * rays.size();
    for (Sighting& ray : rays) {
        ray.end = ends + i;
        if (ray.end->status == Status::escaped) ray.sky = sky_view(plan, *ray.end);
        if (!errors.empty()) ray.error = &errors[i];
        if (wanted.starts) {
            const bool listed = !list.starts.empty();
            block.starts.push_back(listed ? CameraRay{list.starts[i], list.frequencies[i]} : camera_ray(plan, x + 0.5, y + 0.5));
            ray.ray = &block.starts.back();
        }
        ++i;
    }
}

/// Calls `visit(x, y, rays)` with the pixels of a block and the part of `rays` that is theirs.
template <class Rays, class Visit>
void for_pixels(const Tile& pixels, std::uint32_t spp, Rays rays, const Visit& visit) {
    for (std::uint32_t y = pixels.y0; y < pixels.y1; ++y)
        for (std::uint32_t x = pixels.x0; x < pixels.x1; ++x, rays = rays.subspan(spp)) visit(x, y, rays.first(spp));
}

void list_places(const FilmDescription& film, const Tile& pixels, PixelBlock& block) {
    block.places.clear();
    for_pixels(pixels, film.spp, std::span(block.rays), [&](std::uint32_t x, std::uint32_t y, auto) {
        for (std::uint32_t i = 0; i < film.spp; ++i) {
            const auto [u, v] = film.spp == 1 ? std::array{0.5, 0.5} : place_in_pixel(x, y, i, film.spp, film.seed);
            block.places.push_back({x + u, y + v});
        }
    });
}

}  // namespace

bool wants_footprints(const Plan& plan, const Film& film) {
    return plan.geometry->sky_has_pattern() || (needs_of(film) & need_footprint);
}

void shade_tile(const Plan& plan, const Tile& tile, const Tile& shown, const RayEnd* ends, const RayList& list,
                const std::vector<EndError>& errors, Film& film) {
    const Wanted wanted(plan, film);
    const Shader shader(film);
    const TracedTile traced{plan, tile, ends, list, errors};
    const std::uint32_t spp = plan.scene.film.spp;
    PixelBlock block;
    block.starts.reserve(4 * std::size_t(spp));
    for (std::uint32_t by = tile.y0 & ~1u; by < tile.y1; by += 2)
        for (std::uint32_t bx = tile.x0 & ~1u; bx < tile.x1; bx += 2) {
            const Tile pixels{std::max(bx, tile.x0), std::max(by, tile.y0), std::min(bx + 2, tile.x1), std::min(by + 2, tile.y1)};
            block.rays.resize(std::size_t{pixels.x1 - pixels.x0} * (pixels.y1 - pixels.y0) * spp), block.starts.clear();
            for_pixels(pixels, spp, std::span(block.rays), [&](std::uint32_t x, std::uint32_t y, std::span<Sighting> rays) {
                gather(traced, wanted, x, y, block, rays);
            });
            const bool wants_patches = wanted.patches && !find_common_patch(plan, block, spp);
            if (wants_patches || wanted.footprints) list_places(plan.scene.film, pixels, block);
            if (wants_patches) find_patches(plan, block, spp);
            const SkyFootprints footprints = wanted.footprints ? footprints_of(block, spp) : SkyFootprints{};
            for_pixels(pixels, spp, std::span<const Sighting>(block.rays), [&](std::uint32_t x, std::uint32_t y, std::span<const Sighting> rays) {
                if (x < shown.x0 || x >= shown.x1 || y < shown.y0 || y >= shown.y1) return;
                shader.shade({plan, rays, footprints, x, y}, x - shown.x0, y - shown.y0);
            });
        }
}

}  // namespace kagero

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

/// Sets the rays of pixel (x, y), the first of them `first` in the tile, as `rays`. Of what they were before, patches and skies are left
/// that nobody asks of them now.
void gather(const Plan& plan, const Wanted& wanted, const RayEnd* ends, const RayList& list, std::size_t first, std::uint32_t x,
            std::uint32_t y, PixelBlock& block, std::span<Sighting> rays, const std::vector<EndError>& errors) {
    const FilmDescription& film = plan.scene.film;
    for (std::uint32_t i = 0; i < film.spp; ++i) {
        Sighting& ray = rays[i];
        ray.end = ends + first + i;
        if (ray.end->status == Status::escaped) ray.sky = sky_view(plan, *ray.end);
        if (!errors.empty()) ray.error = &errors[first + i];
        if (wanted.starts) {
            const bool listed = !list.starts.empty();
            block.starts.push_back(listed ? CameraRay{list.starts[first + i], list.frequencies[first + i]} : camera_ray(plan, x + 0.5, y + 0.5));
            ray.ray = &block.starts.back();
        }
        if (!wanted.footprints && !wanted.patches) continue;
        const auto [u, v] = film.spp == 1 ? std::array{0.5, 0.5} : place_in_pixel(x, y, i, film.spp, film.seed);
        block.places.push_back({x + u, y + v});
    }
}

}  // namespace

bool wants_footprints(const Plan& plan, const Film& film) {
    return plan.geometry->sky_has_pattern() || (needs_of(film) & need_footprint);
}

void shade_tile(const Plan& plan, const Tile& tile, const Tile& shown, const RayEnd* ends, const RayList& list,
                const std::vector<EndError>& errors, Film& film) {
    const Wanted wanted(plan, film);
    const Shader shader(film);
    const std::uint32_t spp = plan.scene.film.spp, width = tile.x1 - tile.x0;
    PixelBlock block;
    block.starts.reserve(4 * std::size_t(spp));
    for (std::uint32_t by = tile.y0 & ~1u; by < tile.y1; by += 2)
        for (std::uint32_t bx = tile.x0 & ~1u; bx < tile.x1; bx += 2) {
            const std::uint32_t x0 = std::max(bx, tile.x0), x1 = std::min(bx + 2, tile.x1);
            const std::uint32_t y0 = std::max(by, tile.y0), y1 = std::min(by + 2, tile.y1);
            block.rays.resize(std::size_t{x1 - x0} * (y1 - y0) * spp), block.starts.clear(), block.places.clear();
            std::span<Sighting> open = block.rays;
            for (std::uint32_t y = y0; y < y1; ++y)
                for (std::uint32_t x = x0; x < x1; ++x, open = open.subspan(spp))
                    gather(plan, wanted, ends, list, (std::size_t(y - tile.y0) * width + (x - tile.x0)) * spp, x, y, block, open, errors);
            if (wanted.patches) find_patches(plan, block, spp);
            const SkyFootprints footprints = wanted.footprints ? footprints_of(block, spp) : SkyFootprints{};
            std::span<const Sighting> rays = block.rays;
            for (std::uint32_t y = y0; y < y1; ++y)
                for (std::uint32_t x = x0; x < x1; ++x, rays = rays.subspan(spp)) {
                    if (x < shown.x0 || x >= shown.x1 || y < shown.y0 || y >= shown.y1) continue;
                    shader.shade({plan, rays.first(spp), footprints, x, y}, x - shown.x0, y - shown.y0);
                }
        }
}

}  // namespace kagero

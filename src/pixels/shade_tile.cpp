#include "pixels/shade_tile.h"

#include "kernels/assertion.h"
#include "rays/sampler.h"

#include <algorithm>

namespace kagero {
namespace {

/// Data that shading needs in addition to the ends of rays. Members of PixelSample that are not needed are not set.
struct RequiredData {
    bool starts;      ///< True if PixelSample::ray is needed.
    bool footprints;  ///< True if footprints on the sky are needed.
    bool patches;     ///< True if PixelSample::patch is needed.

    RequiredData(const Plan& plan, const Film& film)
        : starts(needs_of(film) & need_start), footprints(needs_footprints(plan, film)),
          patches(plan.scene->paints->surfaces_have_patterns()) {
        for (const ObjectDescription& object : plan.description().objects)
            starts = starts || object.shape == Shape::disk;
    }
};

/// Rays of a tile, with their ends and error estimates.
struct TracedTile {
    const Plan& plan;
    const Tile& tile;
    const TracedRays& rays;
    const std::vector<EndError>& errors;
    const Skies& skies;
    bool plain_skies;  ///< Skies::is_plain.
};

/// Fills `rays` with the rays of consecutive pixels in a row, from pixel (x, y). Patches are not set, nor are the sky
/// views of rays that do not escape.
void collect_samples(const TracedTile& traced, const RequiredData& required, std::uint32_t x, std::uint32_t y,
                     PixelBlock& block, std::span<PixelSample> rays) {
    const auto& [plan, tile, rays_of_tile, errors, skies, plain_skies] = traced;
    const auto& [list, ends, paths] = rays_of_tile;
    const std::uint32_t spp = plan.description().film.spp;
    const std::size_t first = (std::size_t(y - tile.y0) * (tile.x1 - tile.x0) + (x - tile.x0)) * spp;
    for (std::size_t k = 0; k < rays.size(); ++k) {
        PixelSample& ray = rays[k];
        const std::size_t i = first + k;
        ray.end = &ends[i];
        ray.path = paths.empty() ? nullptr : &paths[i];
        if (ray.end->status == Status::escaped) {
            const RayEnd& end = *ray.end;
            if (!plain_skies) ray.sky = sky_view(skies, end);
            else {
                ray.sky.on_second_sheet = false;
                for (std::size_t axis = 0; axis < 3; ++axis) ray.sky.direction[axis] = end.v[axis];
            }
        }
        if (!errors.empty()) ray.error = &errors[i];
        if (required.starts) {
            const bool listed = !list.starts.empty();
            block.starts.push_back(listed ? CameraRay{list.starts[i], list.frequencies[i]}
                                          : camera_ray(plan, x + double(k / spp) + 0.5, y + 0.5));
            ray.ray = &block.starts.back();
        }
    }
}

/// Lists the film positions of all rays of the given pixels.
void list_film_positions(const FilmDescription& film, const Tile& pixels, PixelBlock& block) {
    block.film_positions.clear();
    for (std::uint32_t y = pixels.y0; y < pixels.y1; ++y)
        for (std::uint32_t x = pixels.x0; x < pixels.x1; ++x)
            for (std::uint32_t i = 0; i < film.spp; ++i) {
                const auto [u, v] =
                    film.spp == 1 ? std::array{0.5, 0.5} : sample_position(x, y, i, film.spp, film.seed);
                block.film_positions.push_back({x + u, y + v});
            }
}

/// Returns the intersection of two rectangles of pixels.
Tile intersection(const Tile& a, const Tile& b) {
    return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}

}  // namespace

bool needs_footprints(const Plan& plan, const Film& film) {
    return plan.scene->paints->sky_has_pattern() || (needs_of(film) & need_footprint);
}

void shade_tile(const Plan& plan, const Tile& tile, const Tile& shown, const TracedRays& rays,
                const std::vector<EndError>& errors, Film& film) {
    KAGERO_ASSERT(shown.x1 - shown.x0 == film.width() && shown.y1 - shown.y0 == film.height());
    KAGERO_ASSERT(rays.list.starts.empty() || rays.list.frequencies.size() == rays.list.starts.size());
    const RequiredData required(plan, film);
    const Shader shader(film);
    const TracedTile traced{plan, tile, rays, errors, plan.scene->sources.skies, plan.scene->sources.skies.is_plain()};
    const std::uint32_t spp = plan.description().film.spp;
    PixelBlock block;
    std::vector<SkyFilters> filters;
    block.starts.reserve(4 * std::size_t(spp));
    for (std::uint32_t block_y = tile.y0 & ~1u; block_y < tile.y1; block_y += 2)
        for (std::uint32_t block_x = tile.x0 & ~1u; block_x < tile.x1; block_x += 2) {
            const Tile pixels = intersection({block_x, block_y, block_x + 2, block_y + 2}, tile);
            const Tile shaded = intersection(pixels, shown);
            const std::size_t rays_per_row = std::size_t{pixels.x1 - pixels.x0} * spp;
            block.rays.resize(rays_per_row * (pixels.y1 - pixels.y0));
            block.starts.clear();
            const auto rays_from = [&](std::uint32_t x, std::uint32_t y) {
                return block.rays.data() + (y - pixels.y0) * rays_per_row + (x - pixels.x0) * spp;
            };
            for (std::uint32_t y = pixels.y0; y < pixels.y1; ++y)
                collect_samples(traced, required, pixels.x0, y, block, {rays_from(pixels.x0, y), rays_per_row});
            const std::uint32_t groups = group_by_path(block);
            const bool needs_patches = required.patches && !find_common_patch(*plan.scene->geometry, block, spp);
            if (needs_patches || required.footprints) list_film_positions(plan.description().film, pixels, block);
            if (needs_patches) find_patches(*plan.scene->geometry, block, spp);
            filters.resize(groups);
            for (std::uint32_t group = 0; required.footprints && group < groups; ++group)
                filters[group] = {*plan.scene->paints, footprints_of(block, spp, group)};
            for (std::uint32_t y = shaded.y0; y < shaded.y1; ++y)
                for (std::uint32_t x = shaded.x0; x < shaded.x1; ++x)
                    shader.shade({plan, {rays_from(x, y), spp}, filters, x, y}, x - shown.x0, y - shown.y0);
        }
}

}  // namespace kagero

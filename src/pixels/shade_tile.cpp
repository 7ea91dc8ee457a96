#include "pixels/shade_tile.h"

#include "adaptive/write_ends.h"
#include "appearance/packets/disk_lights.h"
#include "appearance/packets/sky_lookup.h"
#include "geometry/shapes.h"
#include "kernels/assertion.h"
#include "pixels/cell_shader.h"
#include "rays/pixel_rays.h"
#include "scene/vector3.h"

#include <algorithm>

namespace kagero {
namespace {

bool is_disk(const ObjectDescription& object) { return object.shape == Shape::disk; }
bool has_disks(const Plan& plan) {
    return std::any_of(plan.description().objects.begin(), plan.description().objects.end(), is_disk);
}
bool ends_on_disk(const Plan& plan, const RayEnd& end) {
    return end.status == Status::hit && is_disk(plan.description().objects[end.surface]);
}

/// Data that shading needs in addition to the ends of rays. Members of PixelSample that are not needed are not set.
struct RequiredData {
    bool starts;            ///< True if PixelSample::ray is needed for all rays.
    bool disk_starts;       ///< True if PixelSample::ray is needed for rays that end on disks.
    bool footprints;        ///< True if footprints on the sky are needed.
    bool footprint_layers;  ///< True if PixelSample::footprint is needed.
    bool patches;           ///< True if PixelSample::patch is needed.

    RequiredData(const Plan& plan, const Film& film)
        : starts(needs_of(film) & need_start), disk_starts(has_disks(plan)), footprints(needs_footprints(plan, film)),
          footprint_layers(needs_of(film) & need_footprint), patches(plan.scene->paints->surfaces_have_patterns()) {}
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

/// Returns how an escaped ray sees the sky.
SkyView sky_view_of(const TracedTile& traced, const RayEnd& end) {
    if (!traced.plain_skies) return sky_view(traced.skies, end);
    SkyView view;
    view.on_second_sheet = false;
    std::copy_n(end.v, 3, view.direction.begin());
    return view;
}

/// Returns ray i of a tile, which belongs to pixel (x, y).
CameraRay ray_of_tile(const TracedTile& traced, std::size_t i, std::uint32_t x, std::uint32_t y) {
    const RayList& list = traced.rays.list;
    if (list.starts.empty()) return camera_ray(traced.plan, x + 0.5, y + 0.5);
    return {list.starts[i], list.frequencies[i]};
}

/// Fills `samples` with the rays of consecutive pixels in a row, from pixel (x, y). Patches are not set, nor are the
/// sky views of rays that do not escape.
void collect_samples(const TracedTile& traced, const RequiredData& required, std::uint32_t x, std::uint32_t y,
                     PixelBlock& block, std::span<PixelSample> samples) {
    const Tile& tile = traced.tile;
    const TracedRays& rays = traced.rays;
    const std::uint32_t spp = traced.plan.description().film.spp;
    const std::size_t first = (std::size_t(y - tile.y0) * (tile.x1 - tile.x0) + (x - tile.x0)) * spp;
    for (std::size_t k = 0; k < samples.size(); ++k) {
        PixelSample& sample = samples[k];
        const std::size_t i = first + k;
        const RayEnd& end = rays.ends[i];
        sample.end = &end;
        sample.path = rays.paths.empty() ? nullptr : &rays.paths[i];
        sample.interpolated = !rays.traced.empty() && !rays.traced[i];
        if (end.status == Status::escaped) sample.sky = sky_view_of(traced, end);
        if (!traced.errors.empty()) sample.error = &traced.errors[i];
        if (!required.starts && !(required.disk_starts && ends_on_disk(traced.plan, end))) continue;
        block.starts.push_back(ray_of_tile(traced, i, x + static_cast<std::uint32_t>(k / spp), y));
        sample.ray = &block.starts.back();
    }
}

/// Lists the film positions of all rays of the given pixels.
void list_film_positions(const SceneDescription& scene, const Tile& pixels, PixelBlock& block) {
    const PixelRays pixel_rays(scene);
    const FilmDescription& film = scene.film;
    block.film_positions.clear();
    for (std::uint32_t y = pixels.y0; y < pixels.y1; ++y)
        for (std::uint32_t x = pixels.x0; x < pixels.x1; ++x)
            for (std::uint32_t i = 0; i < film.spp; ++i) {
                const auto [u, v] = film.spp == 1 ? std::array{0.5, 0.5} : pixel_rays.position(x, y, i);
                block.film_positions.push_back({x + u, y + v});
            }
}

/// Returns the intersection of two rectangles of pixels.
Tile intersection(const Tile& a, const Tile& b) {
    return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}

/// Returns the footprint for a ray that is the only one of its block to escape to its sky, while others are captured or
/// escape to the other sky. Such a ray has passed close to the photon sphere, where every pixel shows the whole sky
/// many times. Its footprint is therefore large.
Footprint lone_ray_footprint(const SkyView& view) {
    constexpr double large = 0.5;  // radian
    const auto [e1, e2] = axes_around(view.direction);
    return {scaled(e1, large), scaled(e2, large)};
}

/// Adds the escaped rays of a block without a common sky to those whose skies are looked up. `groups` is the number of
/// groups of its rays.
void add_to_skies(const RequiredData& required, std::uint32_t spp, std::uint32_t groups, PixelBlock& block,
                  SkyLookup& skies) {
    for (PixelSample& ray : block.rays)
        if (is_scattered(ray) && ray.end->status == Status::escaped) skies.add(ray, {});
    for (std::uint32_t group = 0; group < groups; ++group) {
        const SkyFootprints found = required.footprints ? footprints_of(block, spp, group) : SkyFootprints{};
        for (PixelSample& ray : block.rays) {
            if (ray.end->status != Status::escaped || ray.group != group) continue;
            ray.footprint = ray.sky.on_second_sheet ? found.second_sheet : found.first_sheet;
            const bool is_lone = found.discontinuous && !(length(ray.footprint.major) > 0);
            skies.add(ray, is_lone ? lone_ray_footprint(ray.sky) : ray.footprint);
        }
    }
}

/// Adds those rays of a block that end on disks with a temperature.
void add_to_disks(const Paints& paints, PixelBlock& block, DiskLights& disks) {
    for (PixelSample& ray : block.rays)
        if (ray.end->status == Status::hit && paints.object(ray.end->surface).temperature > 0) disks.add(ray);
}

/// Fills a block with the rays of its pixels, finds their patches, and adds the rays to `skies` and `disks`.
void prepare_block(const TracedTile& traced, const RequiredData& required, const Tile& pixels, PixelBlock& block,
                   SkyLookup& skies, DiskLights& disks) {
    const FilmDescription& film = traced.plan.description().film;
    const SceneGeometry& geometry = *traced.plan.scene->geometry;
    const std::uint32_t spp = film.spp;
    const std::size_t rays_per_row = std::size_t{pixels.x1 - pixels.x0} * spp;
    block.pixels = pixels;
    block.rays.resize(rays_per_row * (pixels.y1 - pixels.y0));
    block.starts.clear();
    block.starts.reserve(4 * std::size_t(spp));
    for (std::uint32_t y = pixels.y0; y < pixels.y1; ++y)
        collect_samples(traced, required, pixels.x0, y, block,
                        {block.rays.data() + (y - pixels.y0) * rays_per_row, rays_per_row});
    const std::uint32_t groups = group_by_path(block);
    if (have_common_sky(block, spp)) return skies.add_block(std::span(block.rays).first<4>());
    const bool needs_patches = required.patches && !find_common_patch(geometry, block, spp);
    if (needs_patches || required.footprints) list_film_positions(traced.plan.description(), pixels, block);
    if (needs_patches) find_patches(geometry, block, spp);
    add_to_skies(required, spp, groups, block, skies);
    if (required.disk_starts) add_to_disks(*traced.plan.scene->paints, block, disks);
}

/// Computes the layers of those pixels of a block that lie in the rectangle `shown`.
void shade_block(const Plan& plan, const PixelBlock& block, const Tile& shown, const Shader& shader) {
    const std::uint32_t spp = plan.description().film.spp;
    const Tile &pixels = block.pixels, shaded = intersection(pixels, shown);
    for (std::uint32_t y = shaded.y0; y < shaded.y1; ++y)
        for (std::uint32_t x = shaded.x0; x < shaded.x1; ++x) {
            const std::size_t first = (std::size_t{y - pixels.y0} * (pixels.x1 - pixels.x0) + (x - pixels.x0)) * spp;
            shader.shade({plan, {block.rays.data() + first, spp}, x, y}, x - shown.x0, y - shown.y0);
        }
}

/// The pixels of a tile that are shaded in cells, as squares of 8 × 8 pixels of the film.
class ShadedSquares {
public:
    static constexpr std::uint32_t edge = 8;

    explicit ShadedSquares(const Tile& tile)
        : x0_(tile.x0 / edge), y0_(tile.y0 / edge), columns_((tile.x1 - 1) / edge - x0_ + 1),
          is_shaded_(std::size_t{columns_} * ((tile.y1 - 1) / edge - y0_ + 1)) {}

    void add(const RayCell& cell) {
        for (std::uint32_t y = cell.y; y < cell.y + cell.edge; y += edge)
            for (std::uint32_t x = cell.x; x < cell.x + cell.edge; x += edge)
                if (x / edge >= x0_ && x / edge < x0_ + columns_ && y / edge >= y0_ && index(x, y) < is_shaded_.size())
                    is_shaded_[index(x, y)] = true;
    }
    /// Returns true if pixel (x, y) of the tile is shaded in a cell.
    bool contain(std::uint32_t x, std::uint32_t y) const { return is_shaded_[index(x, y)]; }

private:
    std::size_t index(std::uint32_t x, std::uint32_t y) const {
        return std::size_t{y / edge - y0_} * columns_ + (x / edge - x0_);
    }

    std::uint32_t x0_, y0_, columns_;
    std::vector<bool> is_shaded_;
};

/// Shades a cell, or its parts if the whole cell cannot be shaded as a unit. Returns false if this is true of a part.
bool shade_parts(const CellShader& shader, const RayCell& cell, ShadedSquares& shaded) {
    if (shader.shade(cell)) {
        shaded.add(cell);
        return true;
    }
    if (cell.edge < 2 * ShadedSquares::edge || !shader.shades_cells()) return false;
    bool all = true;
    for (const RayCell& quarter : quarters_of(cell)) all &= shade_parts(shader, quarter, shaded);
    return all;
}

/// Shades the cells of a tile. Sets the ray ends of those cells that cannot be shaded as units.
ShadedSquares shade_cells(const Plan& plan, const Tile& tile, const Tile& shown, TracedRays& rays, Film& film) {
    ShadedSquares shaded(tile);
    const CellShader shader(plan, shown, film);
    for (const RayCell& cell : rays.cells)
        if (!shade_parts(shader, cell, shaded)) write_ends(cell, tile, rays);
    return shaded;
}

}  // namespace

bool needs_footprints(const Plan& plan, const Film& film) {
    return plan.scene->paints->sky_has_pattern() || (needs_of(film) & need_footprint);
}

void shade_tile(const Plan& plan, const Tile& tile, const Tile& shown, TracedRays& rays,
                const std::vector<EndError>& errors, Film& film) {
    KAGERO_ASSERT(shown.x1 - shown.x0 == film.width() && shown.y1 - shown.y0 == film.height());
    KAGERO_ASSERT(rays.list.starts.empty() || rays.list.frequencies.size() == rays.list.starts.size());
    const ShadedSquares shaded = shade_cells(plan, tile, shown, rays, film);
    const RequiredData required(plan, film);
    const Shader shader(film);
    const TracedTile traced{plan, tile, rays, errors, plan.scene->sources.skies, plan.scene->sources.skies.is_plain()};
    SkyLookup skies(plan.module(), *plan.scene->paints, required.footprint_layers);
    DiskLights disks(plan.module(), *plan.scene->paints, plan.scene->sources, plan.view.spacetime);
    std::vector<PixelBlock> row((tile.x1 + 1) / 2 - tile.x0 / 2);
    for (std::uint32_t y = tile.y0 & ~1u; y < tile.y1; y += 2) {
        std::size_t blocks = 0;
        for (std::uint32_t x = tile.x0 & ~1u; x < tile.x1; x += 2) {
            const Tile pixels = intersection({x, y, x + 2, y + 2}, tile);
            if (!shaded.contain(pixels.x0, pixels.y0))
                prepare_block(traced, required, pixels, row[blocks++], skies, disks);
        }
        skies.finish();
        disks.finish();
        for (const PixelBlock& block : std::span(row).first(blocks)) shade_block(plan, block, shown, shader);
    }
}

}  // namespace kagero

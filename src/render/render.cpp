#include "render/render.h"

#include "render/end_errors.h"
#include "render/footprint.h"
#include "render/predict.h"
#include "render/run.h"
#include "render/sampler.h"
#include "render/shade.h"
#include "render/snapshot.h"

#include <chrono>

#include <algorithm>

namespace kagero {
namespace {

/// Rays of the crop, or of the whole film.
Tile window(const Plan& plan) {
    const auto& c = plan.options.crop;
    if (c[2] == 0) return {0, 0, plan.scene.film.width, plan.scene.film.height};
    return {c[0], c[1], c[2], c[3]};
}

bool wants_footprints(const Plan& plan, const Film& film) {
    return plan.geometry->sky_has_pattern() || film.has("footprint") || film.has("magnification");
}

/// The pixels to trace: where footprints or patches are wanted, whole blocks of 2 × 2 pixels of the film's grid.
Tile traced_window(const Plan& plan, const Film& film) {
    Tile w = window(plan);
    if (!wants_footprints(plan, film) && !plan.geometry->surfaces_have_patterns()) return w;
    w.x0 &= ~1u, w.y0 &= ~1u;
    w.x1 = std::min(w.x1 + (w.x1 & 1), plan.scene.film.width), w.y1 = std::min(w.y1 + (w.y1 & 1), plan.scene.film.height);
    return w;
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

/// What shading has to know of rays beside their ends; what is not wanted is left empty.
struct Wanted {
    bool starts, footprints, patches;

    Wanted(const Plan& plan, const Film& film)
        : starts(film.has("depth") || film.has("redshift")), footprints(wants_footprints(plan, film)), patches(plan.geometry->surfaces_have_patterns()) {
        for (const ObjectDescription& object : plan.scene.objects) starts = starts || object.shape == Shape::disk;
    }
};

/// Adds the rays of pixel (x, y), the first of them `first` in the tile.
void gather(const Plan& plan, const Wanted& wanted, const RayEnd* ends, const RayList& list, std::size_t first, std::uint32_t x,
            std::uint32_t y, Quad& quad, const std::vector<EndError>& errors) {
    const FilmDescription& film = plan.scene.film;
    for (std::uint32_t i = 0; i < film.spp; ++i) {
        Sighting& ray = quad.rays.emplace_back();
        ray.end = ends + first + i;
        if (!errors.empty()) ray.error = &errors[first + i];
        if (!list.starts.empty())
            ray.ray = {list.starts[first + i], list.frequencies[first + i]};
        else if (wanted.starts)
            ray.ray = camera_ray(plan, x + 0.5, y + 0.5);
        if (!wanted.footprints && !wanted.patches) continue;
        const auto [u, v] = film.spp == 1 ? std::array{0.5, 0.5} : place_in_pixel(x, y, i, film.spp, film.seed);
        quad.places.push_back({x + u, y + v});
    }
}

/// Shades the pixels of a tile that lie in the window `film` shows, in blocks of 2 × 2.
void shade_tile(const Plan& plan, const Tile& tile, const Tile& shown, const RayEnd* ends, const RayList& list, Film& film,
                const std::vector<EndError>& errors) {
    const Wanted wanted(plan, film);
    const Shader shader(film);
    const std::uint32_t spp = plan.scene.film.spp, width = tile.x1 - tile.x0;
    Quad quad;
    for (std::uint32_t by = tile.y0 & ~1u; by < tile.y1; by += 2)
        for (std::uint32_t bx = tile.x0 & ~1u; bx < tile.x1; bx += 2) {
            const std::uint32_t x0 = std::max(bx, tile.x0), x1 = std::min(bx + 2, tile.x1);
            const std::uint32_t y0 = std::max(by, tile.y0), y1 = std::min(by + 2, tile.y1);
            quad.rays.clear(), quad.places.clear();
            for (std::uint32_t y = y0; y < y1; ++y)
                for (std::uint32_t x = x0; x < x1; ++x)
                    gather(plan, wanted, ends, list, (std::size_t(y - tile.y0) * width + (x - tile.x0)) * spp, x, y, quad, errors);
            if (wanted.patches) find_patches(plan, quad, spp);
            const SkyFootprints footprints = wanted.footprints ? footprints_of(plan, quad, spp) : SkyFootprints{};
            std::span<const Sighting> rays = quad.rays;
            for (std::uint32_t y = y0; y < y1; ++y)
                for (std::uint32_t x = x0; x < x1; ++x, rays = rays.subspan(spp)) {
                    if (x < shown.x0 || x >= shown.x1 || y < shown.y0 || y >= shown.y1) continue;
                    shader.shade({plan, rays.first(spp), footprints, x, y}, x - shown.x0, y - shown.y0);
                }
        }
}

}  // namespace

RunReport render(const Plan& plan, Film& film, const Watch& watch) {
    const auto begin = std::chrono::steady_clock::now();
    Job job = plan.job;
    if (film.has("energy_error")) job.outputs |= output_energy;
    TileRays rays;
    if (!kernel_makes_rays(plan)) rays = [&](const Tile& tile, RayList& list) { list_rays(plan, tile, list); };
    const EndErrors end_errors(plan, film.has("position_error"), film.has("rounding_error"));
    Snapshots snapshots(watch, film);
    const auto done = [&, shown = window(plan)](const Tile& tile, const RayEnd* ends, const RayList& list) {
        const std::vector<EndError> errors = end_errors.of(tile, ends, list);
        snapshots.write([&] { shade_tile(plan, tile, shown, ends, list, film, errors); });
        snapshots.take();
    };
    const Schedule schedule = schedule_of(plan);
    WorkList work = cut(plan, traced_window(plan, film), schedule);
    if (schedule == Schedule::predicted) {
        predict_costs(plan, work, watch.stop);
        put_costliest_first(work);
    }
    const double predict_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    Watch rest = watch;
    rest.time_limit -= predict_seconds;
    RunReport report = run_tiles(plan, job, work, rays, done, rest);
    report.schedule = schedule;
    report.predict_seconds = predict_seconds;
    report.seconds += predict_seconds;
    return report;
}

}  // namespace kagero

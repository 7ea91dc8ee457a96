#include "render/render.h"

#include "rays/camera.h"
#include "accuracy/end_errors.h"
#include "rays/list_rays.h"
#include "render/predict.h"
#include "render/run.h"
#include "pixels/shade_tile.h"
#include "render/snapshot.h"

#include <chrono>

namespace kagero {
namespace {

/// The pixels to trace: where footprints or patches are wanted, whole blocks of 2 × 2 pixels of the film's grid. The last ones reach beyond a
/// film of odd size.
Tile traced_part(const Plan& plan, const Film& film) {
    Tile w = shown_part(plan);
    if (!wants_footprints(plan, film) && !plan.geometry->surfaces_have_patterns()) return w;
    w.x0 &= ~1u, w.y0 &= ~1u;
    w.x1 += w.x1 & 1, w.y1 += w.y1 & 1;
    return w;
}

}  // namespace

Tile shown_part(const Plan& plan) {
    const auto& c = plan.options.crop;
    if (c[2] == 0) return {0, 0, plan.scene.film.width, plan.scene.film.height};
    return {c[0], c[1], c[2], c[3]};
}

Film film_of(const Plan& plan) {
    const Tile part = shown_part(plan);
    const FilmDescription& film = plan.scene.film;
    try {
        return Film(part.x1 - part.x0, part.y1 - part.y0, film.layers, {part.x0, part.y0, film.width, film.height});
    } catch (const std::bad_alloc&) {
        throw RunError("there is not enough memory for the film: 12 bytes per pixel for color, 4 for every other layer");
    }
}

RunReport render(const Plan& plan, Film& film, const Watch& watch) {
    const auto begin = std::chrono::steady_clock::now();
    Job job = plan.job;
    const unsigned needs = needs_of(film);
    if (needs & need_energy_error) job.outputs |= output_energy;
    TileRays rays;
    if (!kernel_makes_rays(plan)) rays = [&](const Tile& tile, RayList& list) { list_rays(plan, tile, list); };
    const EndErrors end_errors(plan, needs & need_position_error, needs & need_rounding_error);
    Snapshots snapshots(watch, film);
    const auto done = [&, shown = shown_part(plan)](const Tile& tile, const RayEnd* ends, const RayList& list, const Halt& halt) {
        const std::vector<EndError> errors = end_errors.of(tile, ends, list, halt);
        if (!errors.empty() && halt()) return;
        snapshots.write([&] { shade_tile(plan, tile, shown, ends, list, errors, film); });
        snapshots.take();
    };
    const Schedule schedule = schedule_of(plan);
    WorkList work = cut(plan, traced_part(plan, film), schedule);
    if (schedule == Schedule::predicted) {
        predict_costs(plan, film, work, watch);
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

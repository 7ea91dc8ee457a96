#include "render/render.h"

#include "error.h"
#include "pixels/shade_tile.h"
#include "render/predict.h"
#include "render/snapshot.h"

#include <chrono>

namespace kagero {
namespace {

/// The pixels to trace: where footprints or patches are wanted, whole blocks of 2 × 2 pixels of the film's grid. The
/// last ones reach beyond a film of odd size.
Tile traced_part(const Plan& plan, const Film& film) {
    Tile w = plan.view.window;
    if (!wants_footprints(plan, film) && !plan.scene->paints->surfaces_have_patterns()) return w;
    w.x0 &= ~1u, w.y0 &= ~1u;
    w.x1 += w.x1 & 1, w.y1 += w.y1 & 1;
    return w;
}

}  // namespace

Film film_of(const Plan& plan) {
    const Tile& part = plan.view.window;
    const FilmDescription& film = plan.description().film;
    try {
        return Film(part.x1 - part.x0, part.y1 - part.y0, film.layers, {part.x0, part.y0, film.width, film.height});
    } catch (const std::bad_alloc&) {
        throw RunError(
            "there is not enough memory for the film: 12 bytes per pixel for color, 4 for every other layer");
    }
}

RunReport render(const Plan& plan, Film& film, const Watch& watch, const TileErrors& errors) {
    const auto begin = std::chrono::steady_clock::now();
    Job job = plan.job();
    const unsigned needs = needs_of(film);
    if (needs & need_energy_error) job.outputs |= output_energy;
    TileRays rays;
    if (!job.camera) rays = [&](const Tile& tile, RayList& list) { list_rays(plan, tile, list); };
    const bool wants_errors = needs & (need_position_error | need_rounding_error);
    if (wants_errors && !errors)
        throw RunError("the film has a layer of errors, but nothing estimates them: use render_with_errors");
    Snapshots snapshots(watch, film);
    const auto done = [&, shown = plan.view.window](const Tile& tile, const RayEnd* ends, const RayList& list,
                                                    const Halt& halt) {
        const std::vector<EndError> estimates = wants_errors ? errors(tile, ends, list, halt) : std::vector<EndError>{};
        if (wants_errors && halt()) return;
        snapshots.write([&] { shade_tile(plan, tile, shown, ends, list, estimates, film); });
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

#include "render/render.h"

#include "error.h"
#include "pixels/shade_tile.h"
#include "render/predict.h"
#include "render/snapshot.h"

#include <chrono>

namespace kagero {
namespace {

/// Returns the pixels to trace. If footprints or patches are needed, these are complete blocks of 2 × 2 pixels, aligned
/// with the film. The blocks extend beyond a film with an odd number of rows or columns.
Tile traced_window(const Plan& plan, const Film& film) {
    Tile window = plan.view.window;
    if (!needs_footprints(plan, film) && !plan.scene->paints->surfaces_have_patterns()) return window;
    window.x0 &= ~1u;
    window.y0 &= ~1u;
    window.x1 += window.x1 & 1;
    window.y1 += window.y1 & 1;
    return window;
}

/// Removes the tiles that `selects` refuses.
void select_tiles(WorkList& work, const std::function<bool(const Tile&)>& selects) {
    WorkList selected;
    for (std::size_t i = 0; i < work.tiles.size(); ++i)
        if (selects(work.tiles[i])) {
            selected.tiles.push_back(work.tiles[i]);
            selected.costs.push_back(work.costs[i]);
        }
    work = std::move(selected);
}

}  // namespace

TileGrid tile_grid_of(const Plan& plan, const Film& film) {
    return tile_grid(plan, traced_window(plan, film), schedule_of(plan));
}

Film film_of(const Plan& plan) {
    const Tile& window = plan.view.window;
    const FilmDescription& film = plan.description().film;
    try {
        return Film(window.x1 - window.x0, window.y1 - window.y0, film.layers,
                    {window.x0, window.y0, film.width, film.height}, film.tone);
    } catch (const std::bad_alloc&) {
        throw RunError(
            "not enough memory for the film, which needs 12 bytes per pixel for color and 4 for every other layer; "
            "reduce film.size or film.layers");
    }
}

RunReport render(const Plan& plan, Film& film, const RunControl& control, const TileErrors& estimate_errors) {
    const auto begin = std::chrono::steady_clock::now();
    Job job = plan.medium(plan.view.medium).job();
    const unsigned needs = needs_of(film);
    if (needs & need_energy_error) job.outputs |= output_energy;
    if (needs & need_action) job.outputs |= output_action;
    if (needs & need_time) job.outputs |= output_time;
    TileRays rays;
    if (!job.camera) rays = [&](const Tile& tile, RayList& list) { list_rays(plan, tile, list); };
    const bool needs_errors = needs & (need_position_error | need_rounding_error);
    if (needs_errors && !estimate_errors)
        throw RunError(
            "the layers position_error and rounding_error need an estimator of errors; call render_with_errors");
    Snapshots snapshots(control, film);
    const auto finish_tile = [&, shown = plan.view.window](const Tile& tile, TracedRays& traced,
                                                           const CancelToken& cancel) {
        const std::vector<EndError> estimates =
            needs_errors ? estimate_errors(tile, traced, cancel) : std::vector<EndError>{};
        if (needs_errors && cancel()) return;
        snapshots.write([&] { shade_tile(plan, tile, shown, traced, estimates, film); });
        snapshots.deliver_if_requested();
    };
    const Schedule schedule = schedule_of(plan);
    WorkList work = split_into_tiles(plan, tile_grid_of(plan, film));
    if (control.selects_tile) select_tiles(work, control.selects_tile);
    if (schedule == Schedule::predicted && !work.tiles.empty()) {
        predict_costs(plan, film, work, control);
        sort_by_descending_cost(work);
    }
    const double predict_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    RunControl remaining_control = control;
    remaining_control.time_limit -= predict_seconds;
    RunReport report = run_tiles(plan, job, work, rays, finish_tile, remaining_control, branch_choice_of(plan),
                                 plan.run.interpolation_bound);
    report.schedule = schedule;
    report.predict_seconds = predict_seconds;
    report.seconds += predict_seconds;
    return report;
}

}  // namespace kagero

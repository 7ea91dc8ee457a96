#include "render/render.h"

#include "error.h"
#include "pixels/shade_tile.h"
#include "render/predict.h"
#include "render/snapshot.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <mutex>

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

/// Returns the outputs of rays that these needs of the film's layers require.
unsigned outputs_for(unsigned needs) {
    unsigned outputs = 0;
    if (needs & need_energy_error) outputs |= output_energy;
    if (needs & need_action) outputs |= output_action;
    if (needs & need_time) outputs |= output_time;
    return outputs;
}

/// Returns the pixels of a tile that are in the picture.
Tile shown_pixels(const Tile& tile, const Tile& window) {
    return {std::max(tile.x0, window.x0), std::max(tile.y0, window.y0), std::min(tile.x1, window.x1),
            std::min(tile.y1, window.y1)};
}

/// Films of single tiles, from the time when their pixels are computed to the time when their reports are complete.
class TileFilms {
public:
    explicit TileFilms(const Plan& plan) : plan_(plan) {}

    /// Computes the pixels of a tile.
    void shade(const Tile& tile, TracedRays& traced, const std::vector<EndError>& estimates) {
        const FilmDescription& film = plan_.description().film;
        const Tile shown = shown_pixels(tile, plan_.view.window);
        Film pixels(shown.x1 - shown.x0, shown.y1 - shown.y0, film.layers,
                    {shown.x0, shown.y0, film.width, film.height}, film.tone);
        shade_tile(plan_, tile, shown, traced, estimates, pixels);
        const std::lock_guard lock(changing_);
        films_.emplace(std::pair{tile.y0, tile.x0}, std::move(pixels));
    }
    /// Returns the film of a tile, and forgets it.
    Film take(const Tile& tile) {
        const std::lock_guard lock(changing_);
        return std::move(films_.extract({tile.y0, tile.x0}).mapped());
    }

private:
    const Plan& plan_;
    std::map<std::pair<std::uint32_t, std::uint32_t>, Film> films_;  ///< By the first pixel of the tile.
    std::mutex changing_;
};

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

Film film_of(const Plan& plan, Planes planes) {
    const Tile& window = plan.view.window;
    const FilmDescription& film = plan.description().film;
    try {
        return Film(window.x1 - window.x0, window.y1 - window.y0, film.layers,
                    {window.x0, window.y0, film.width, film.height}, film.tone, planes);
    } catch (const std::bad_alloc&) {
        throw RunError(
            "not enough memory for the film, which needs 12 bytes per pixel for color and 4 for every other layer; "
            "reduce film.size or film.layers");
    }
}

RunReport render(const Plan& plan, Film& film, const RunControl& control, const TileErrors& estimate_errors) {
    const auto begin = std::chrono::steady_clock::now();
    const unsigned needs = needs_of(film);
    Job job = plan.medium(plan.view.medium).job();
    job.outputs |= outputs_for(needs);
    TileRays rays;
    if (!job.camera) rays = [&](const Tile& tile, RayList& list) { list_rays(plan, tile, list); };
    const bool needs_errors = needs & (need_position_error | need_rounding_error);
    if (needs_errors && !estimate_errors)
        throw RunError(
            "the layers position_error and rounding_error need an estimator of errors; call render_with_errors");
    Snapshots snapshots(control, film);
    TileFilms tile_films(plan);
    const auto finish_tile = [&, shown = plan.view.window](const Tile& tile, TracedRays& traced,
                                                           const CancelToken& cancel) {
        const std::vector<EndError> estimates =
            needs_errors ? estimate_errors(tile, traced, cancel) : std::vector<EndError>{};
        if (needs_errors && cancel()) return;
        if (control.tile_film_finished) tile_films.shade(tile, traced, estimates);
        else snapshots.write([&] { shade_tile(plan, tile, shown, traced, estimates, film); });
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
    if (control.tile_film_finished)
        remaining_control.tile_finished = [&](const Tile& tile, TileReport tile_report) {
            control.tile_film_finished(tile, std::move(tile_report), tile_films.take(tile));
        };
    RunReport report = run_tiles(plan, job, work, rays, finish_tile, remaining_control, branch_choice_of(plan),
                                 plan.run.interpolation_bound);
    report.schedule = schedule;
    report.predict_seconds = predict_seconds;
    report.seconds += predict_seconds;
    return report;
}

}  // namespace kagero

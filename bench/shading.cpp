// Question: how long does shading take per pixel, without the tracing of rays? Traces tiles of the pictures at 1280 x
// 720 once, and then computes their pixels again and again on one thread. `sky/SCENE` uses the tiles all of whose rays
// escape, and `surfaces/SCENE` those all of whose rays hit an object. The counter `per_pixel` is the time of the
// processor per pixel.
#include "modules/modules.h"
#include "pixels/shade_tile.h"
#include "render/render.h"
#include "scene/load/load.h"
#include "tuning/resolve.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <memory>
#include <mutex>
#include <string>

namespace {

using namespace kagero;

struct TracedTile {
    Tile tile;
    TracedRays rays;
};

/// A picture with those of its traced tiles all of whose rays end with one status.
struct Picture {
    Plan plan;
    Film film;
    std::vector<TracedTile> tiles;
    std::uint64_t pixels = 0;

    Picture(const std::string& scene, Status status, const Options& options)
        : plan(
              resolve(load_scene(KAGERO_SCENES "/" + scene + ".toml", {"film.size=[1280,720]"}, catalogue(options.isa)),
                      options)),
          film(film_of(plan)) {
        WorkList work;
        const WorkList all = split_into_tiles(plan, tile_grid_of(plan, film));
        for (std::size_t i = 0; i < all.tiles.size(); i += tile_interval) work.tiles.push_back(all.tiles[i]);
        const auto keep = [&](const Tile& tile, const TracedRays& traced, const CancelToken&) {
            if (std::any_of(traced.ends.begin(), traced.ends.end(),
                            [&](const RayEnd& end) { return end.status != status; }))
                return;
            tiles.push_back({tile, traced});
            pixels += std::uint64_t{tile.x1 - tile.x0} * (tile.y1 - tile.y0);
        };
        run_tiles(plan, plan.job(), work, {}, keep, {}, BranchChoice::stronger);
    }

private:
    /// Only every 48th tile is used, so that the ends of rays remain in the processor's cache, as in a render.
    static constexpr std::size_t tile_interval = 48;
};

void shade(benchmark::State& state, const std::string& scene, Status status) {
    Options options;
    options.threads = 1;
    Picture picture(scene, status, options);
    if (picture.pixels == 0) return state.SkipWithError("no tile of the picture has only rays with this end");
    for (auto _ : state)
        for (TracedTile& traced : picture.tiles)
            shade_tile(picture.plan, traced.tile, picture.plan.view.window, traced.rays, {}, picture.film);
    using benchmark::Counter;
    state.counters["per_pixel"] =
        Counter(double(picture.pixels), Counter::kIsIterationInvariantRate | Counter::kInvert);
}

void add(const char* kind, const std::string& scene, Status status) {
    benchmark::RegisterBenchmark((std::string(kind) + "/" + scene).c_str(), [=](benchmark::State& state) {
        shade(state, scene, status);
    })->Unit(benchmark::kMillisecond);
}

}  // namespace

int main(int count, char** arguments) {
    for (const char* scene : {"galaxy", "hole", "wormhole", "kerr"}) add("sky", scene, Status::escaped);
    for (const char* scene : {"room", "kerr", "mirage"}) add("surfaces", scene, Status::hit);
    benchmark::Initialize(&count, arguments);
    if (benchmark::ReportUnrecognizedArguments(count, arguments)) return 2;
    benchmark::RunSpecifiedBenchmarks();
    return 0;
}

// Question: how long does a picture take? Renders scenes/room.toml on one thread with every kernel module that this CPU
// can run. With rg = 0, rays are straight, and the time is compared with that of a loop that only queries Embree, with
// the same rays and shading.
#include "bench/bare_embree.h"
#include "modules/modules.h"
#include "pixels/shade_tile.h"
#include "plan/names.h"
#include "render/render.h"
#include "scene/load/load.h"
#include "tuning/resolve.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <set>
#include <string>

namespace {

using namespace kagero;

/// A method with its step, as overrides of the scene.
struct Integration {
    const char* name;
    std::vector<Override> overrides;
};
const Integration integrations[] = {
    {"default", {}},
    {"gauss4", {"integrator.method=gauss4", "integrator.step=0.5"}},
    {"verlet", {"integrator.method=verlet", "integrator.step=0.1"}},
    {"verlet_fine", {"integrator.method=verlet", "integrator.step=0.05"}},
};

/// Options and scene overrides of one benchmark.
struct RenderCase {
    Options options;
    std::vector<Override> overrides;
};

void render_room(benchmark::State& state, const RenderCase& render_case) {
    const auto plan =
        make_plan(load_scene(KAGERO_SCENES "/room.toml", render_case.overrides, catalogue(render_case.options.isa)),
                  render_case.options);
    Film film = film_of(plan);
    RunReport report;
    for (auto _ : state) report = render(plan, film);
    const Counters& c = report.counters;
    const double rays = double(report.rays);
    using benchmark::Counter;
    state.counters["rays/s"] = Counter(rays, Counter::kIsIterationInvariantRate);
    state.counters["steps/s"] = Counter(double(c.steps), Counter::kIsIterationInvariantRate);
    state.counters["steps/ray"] = double(c.steps) / rays;
    state.counters["gradients/ray"] = double(c.gradients) / rays;
    state.counters["queries/ray"] = double(c.queries) / rays;
    state.counters["occupancy"] = double(c.active_lane_steps) / double(c.issued_lane_steps);
    // Share of the lane-iterations of implicit solves in which the lane had not converged.
    if (c.issued_iterations) state.counters["iterating"] = double(c.active_iterations) / double(c.issued_iterations);
}

/// Returns the plan of `kagero render` for the room with straight rays. Trial rays choose the precision.
Plan straight_room(const std::string& isa) {
    Options options;
    options.isa = isa;
    options.threads = 1;
    return resolve(load_scene(KAGERO_SCENES "/room.toml", {"space.rg=0"}, catalogue(isa)), options);
}
void render_kagero(const Plan& plan, Film& film) {
    render(plan, film);
}
/// Traces all tiles with bare_embree instead of the kernels of kagero, and calls finish(tile, rays) for each.
template <class Finish>
void trace_bare(const Plan& plan, const Finish& finish) {
    const Job job = plan.job();
    TracedRays rays;
    for (const Tile& tile : split_into_tiles(plan, plan.view.window, Schedule::tiles).tiles) {
        rays.ends.resize(ray_count_of(tile, {}));
        bench::bare_embree(*job.camera, *job.geometry, job.escape_radius, tile, rays.ends.data());
        finish(tile, rays);
    }
}
void render_bare(const Plan& plan, Film& film) {
    trace_bare(plan,
               [&](const Tile& tile, TracedRays& rays) { shade_tile(plan, tile, plan.view.window, rays, {}, film); });
}
/// Traces the rays of the picture, but computes no colours.
void trace_without_shading(const Plan& plan, Film&) {
    trace_bare(plan, [](const Tile&, TracedRays& rays) { benchmark::DoNotOptimize(rays.ends.data()); });
}

/// Ends the program with status 1 if the pictures of kagero and bare_embree differ in more than one pixel in a
/// thousand. Pixels at edges of objects may differ. Compares the pictures only once per instruction set.
void require_same_picture(const std::string& isa) {
    static std::set<std::string> compared;
    if (!compared.insert(isa).second) return;
    const auto plan = straight_room(isa);
    Film kagero_film = film_of(plan), bare_film = film_of(plan);
    render_kagero(plan, kagero_film);
    render_bare(plan, bare_film);
    const std::size_t pixels = std::size_t{kagero_film.width()} * kagero_film.height();
    const float *a = kagero_film.plane("color"), *b = bare_film.plane("color");
    std::size_t differing = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
        float greatest = 0;
        for (std::size_t c = 3 * i; c < 3 * i + 3; ++c) greatest = std::max(greatest, std::abs(a[c] - b[c]));
        differing += !(greatest <= 1.0f / 255);
    }
    if (differing <= pixels / 1000) return;
    std::fprintf(stderr,
                 "straight_room/%s: the pictures of kagero and the bare loop differ in %zu pixels; at most %zu may "
                 "differ\n",
                 isa.c_str(), differing, pixels / 1000);
    std::exit(1);
}

/// Registers the benchmarks of the room with straight rays.
void add_straight(const std::string& isa) {
    const auto add = [&](const char* name, void (*render_film)(const Plan&, Film&)) {
        benchmark::RegisterBenchmark(("straight_room/" + isa + "/" + name).c_str(), [=](benchmark::State& state) {
            require_same_picture(isa);
            const auto plan = straight_room(isa);
            Film film = film_of(plan);
            for (auto _ : state) render_film(plan, film);
        })->UseRealTime()->Unit(benchmark::kMillisecond);
    };
    add("kagero", render_kagero);
    add("bare_embree", render_bare);
    add("bare_embree_without_shading", trace_without_shading);
}

/// Registers a benchmark of the room. `cull` is false for queries without culling.
void add(const std::string& isa, const std::string& strategy, const std::string& precision,
         const Integration& integration, bool cull) {
    RenderCase render_case;
    render_case.overrides = integration.overrides;
    render_case.options.isa = isa;
    render_case.options.strategy = strategy_named(strategy);
    render_case.options.precision = precision_named(precision);
    render_case.options.threads = 1;
    render_case.overrides.push_back("film.size=[256,256]");
    if (!cull) render_case.overrides.push_back("integrator.cull=none");
    const std::string path =
        "render_room/" + isa + "/" + integration.name + (cull ? "/" : "_without_culling/") + strategy + "_" + precision;
    benchmark::RegisterBenchmark(path.c_str(),
                                 [render_case](benchmark::State& state) { render_room(state, render_case); })
        ->UseRealTime()->Unit(benchmark::kMillisecond);
}

}  // namespace

int main(int count, char** arguments) {
    for (const IsaInfo& isa : find_isas())
        for (const Integration& integration : integrations)
            for (const char* strategy : {"scalar", "packet"})
                for (const char* precision : {"double", "float"})
                    for (const bool cull : {true, false})
                        if (isa.supported) add(isa.name, strategy, precision, integration, cull);
    for (const IsaInfo& isa : find_isas())
        if (isa.supported) add_straight(isa.name);
    benchmark::Initialize(&count, arguments);
    if (benchmark::ReportUnrecognizedArguments(count, arguments)) return 2;
    benchmark::RunSpecifiedBenchmarks();
    return 0;
}

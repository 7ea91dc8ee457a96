// What does a picture cost? scenes/room.toml on one thread, by every module this CPU can run; and with rg = 0, where
// light is straight, against a loop that knows nothing but Embree, with the same rays and shading.
#include "bench/bare_embree.h"
#include "modules/modules.h"
#include "pixels/shade_tile.h"
#include "plan/names.h"
#include "render/render.h"
#include "scene/load.h"
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

struct Question {
    Options options;
    std::vector<Override> overrides;
};

void picture(benchmark::State& state, const Question& question) {
    const auto plan =
        make_plan(load_scene(KAGERO_SCENES "/room.toml", question.overrides, catalogue(question.options.isa)),
                  question.options);
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
    if (c.issued_iterations) state.counters["iterating"] = double(c.active_iterations) / double(c.issued_iterations);
}

/// As `kagero render` would make its picture: in float, where that is seen to do.
Plan straight_room(const std::string& isa) {
    Options options;
    options.isa = isa, options.threads = 1;
    return resolve(load_scene(KAGERO_SCENES "/room.toml", {"space.rg=0"}, catalogue(isa)), options);
}
void render_ours(const Plan& plan, Film& film) {
    render(plan, film);
}
void render_bare(const Plan& plan, Film& film) {
    const Tile all = plan.view.window;
    const Job job = plan.job();
    std::vector<RayEnd> ends;
    for (const Tile& tile : cut(plan, all, Schedule::tiles).tiles) {
        ends.resize(rays_of(tile, {}));
        bench::bare_embree(*job.camera, *job.geometry, job.escape_radius, tile, ends.data());
        shade_tile(plan, tile, all, ends.data(), {}, {}, film);
    }
}

/// Ends the program unless both ways draw the same picture, but for a pixel in a thousand, at an edge. Once per
/// instruction set.
void require_same_picture(const std::string& isa) {
    static std::set<std::string> compared;
    if (!compared.insert(isa).second) return;
    const auto plan = straight_room(isa);
    Film ours = film_of(plan), bare = film_of(plan);
    render_ours(plan, ours), render_bare(plan, bare);
    const std::size_t pixels = std::size_t{ours.width()} * ours.height();
    const float *a = ours.plane("color"), *b = bare.plane("color");
    std::size_t differing = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
        float most = 0;
        for (std::size_t c = 3 * i; c < 3 * i + 3; ++c) most = std::max(most, std::abs(a[c] - b[c]));
        differing += !(most <= 1.0f / 255);
    }
    if (differing <= pixels / 1000) return;
    std::fprintf(stderr, "straight_room/%s: the bare loop draws %zu pixels otherwise\n", isa.c_str(), differing);
    std::exit(1);
}

void add_straight(const std::string& isa) {
    const auto add = [&](const char* way, void (*draw)(const Plan&, Film&)) {
        benchmark::RegisterBenchmark(("straight_room/" + isa + "/" + way).c_str(), [=](benchmark::State& state) {
            require_same_picture(isa);
            const auto plan = straight_room(isa);
            Film film = film_of(plan);
            for (auto _ : state) draw(plan, film);
        })->UseRealTime()->Unit(benchmark::kMillisecond);
    };
    add("kagero", render_ours);
    add("bare_embree", render_bare);
}

void add(const std::string& isa, const std::string& strategy, const std::string& precision,
         const Integration& integration, bool cull) {
    Question question{{}, integration.overrides};
    question.options.isa = isa, question.options.strategy = strategy_named(strategy),
    question.options.precision = precision_named(precision);
    question.options.threads = 1;
    question.overrides.push_back("film.size=[256,256]");
    if (!cull) question.overrides.push_back("integrator.cull=none");
    const std::string path =
        "render_room/" + isa + "/" + integration.name + (cull ? "/" : "_without_culling/") + strategy + "_" + precision;
    benchmark::RegisterBenchmark(path.c_str(), [question](benchmark::State& state) { picture(state, question); })
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

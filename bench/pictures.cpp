// Question: how long does one picture of a sequence take, with all rays traced and with adaptive sampling? Renders each
// scene at 1280 x 720 again and again with one plan and one film, on two threads, as the viewer does. No file is
// written, and no texture is loaded. `full/SCENE` and `adaptive/SCENE` have the same layers.
#include "modules/modules.h"
#include "render/render.h"
#include "scene/load/load.h"
#include "tuning/resolve.h"

#include <benchmark/benchmark.h>

#include <string>

namespace {

using namespace kagero;

void render_picture(benchmark::State& state, const std::string& scene, const std::string& sampling) {
    Options options;
    options.threads = 2;
    const Plan plan = resolve(load_scene(KAGERO_SCENES "/" + scene + ".toml",
                                         {"film.size=[1280,720]", "film.spp=1", "film.layers=[\"color\"]",
                                          "film.sampling=" + sampling},
                                         catalogue(options.isa)),
                              options);
    Film film = film_of(plan);
    RunReport report;
    for (auto _ : state) report = render(plan, film);
    state.counters["rays_per_pixel"] = double(report.rays) / (1280 * 720);
}

}  // namespace

int main(int count, char** arguments) {
    for (const char* sampling : {"full", "adaptive"})
        for (const char* scene : {"galaxy", "hole", "wormhole", "room", "kerr", "mirage"})
            benchmark::RegisterBenchmark((std::string(sampling) + "/" + scene).c_str(),
                                         [=](benchmark::State& state) { render_picture(state, scene, sampling); })
                ->Unit(benchmark::kMillisecond)
                ->UseRealTime();
    benchmark::Initialize(&count, arguments);
    if (benchmark::ReportUnrecognizedArguments(count, arguments)) return 2;
    benchmark::RunSpecifiedBenchmarks();
    return 0;
}

// What do others take for a list of rays around the hole of scenes/hole.toml, and how well do they end? Each way of
// Boost.Odeint follows them from where they start to the escape sphere; `error` is the greatest angle between where
// they go there and where they go by gauss16.
//
//     bench_peers --rays=FILE [options of Google Benchmark]
#include "bench/odeint.h"
#include "error.h"
#include "modules/modules.h"
#include "rays/start_rays.h"
#include "render/trace.h"
#include "report/csv/read_rays.h"
#include "scene/load.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <limits>

namespace {

using namespace kagero;

struct Rays {
    bench::Hole hole;
    std::vector<RayStart> starts;
    std::vector<RayEnd> ends;
};

Rays rays_of(const char* file) {
    Options options;
    options.threads = 1;
    const std::vector<Override> accurate{"integrator.method=gauss16", "integrator.step=0.1",
                                         "integrator.symmetry=none"};
    const auto plan =
        make_plan(load_scene(KAGERO_SCENES "/hole.toml", accurate, catalogue(options.isa)), options, Purpose::ray_list);
    std::ifstream in(file);
    if (!in) throw InputError(std::string("cannot read the rays '") + file + "'");
    Rays rays{{plan.scene->space.parameters[0], plan.scene->limits.escape_radius},
              start_rays(plan, read_rays(in, file)),
              {}};
    trace(plan, rays.starts, rays.ends);
    return rays;
}

/// The greatest angle; infinite where one has not come out.
double worst_angle(const std::vector<RayEnd>& ends, const std::vector<RayEnd>& should) {
    double worst = 0;
    for (std::size_t i = 0; i < ends.size(); ++i) {
        if (ends[i].status != should[i].status) return std::numeric_limits<double>::infinity();
        const double* a = ends[i].v;
        const double* b = should[i].v;
        worst = std::max(worst, 2 * std::asin(std::min(1.0, 0.5 * std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]))));
    }
    return worst;
}

}  // namespace

int main(int count, char** arguments) try {
    benchmark::Initialize(&count, arguments);
    constexpr const char* option = "--rays=";
    if (count != 2 || std::strncmp(arguments[1], option, std::strlen(option)) != 0) {
        std::fprintf(stderr, "usage: bench_peers --rays=FILE [options of Google Benchmark]\n");
        return 2;
    }
    const Rays rays = rays_of(arguments[1] + std::strlen(option));
    for (const bench::OdeintWay& way : bench::odeint_ways())
        benchmark::RegisterBenchmark(("odeint/" + way.name).c_str(), [&rays, way](benchmark::State& state) {
            std::vector<RayEnd> ends(rays.starts.size());
            for (auto _ : state) way.follow(rays.hole, way.number, rays.starts, ends);
            using benchmark::Counter;
            state.counters["s/ray"] =
                Counter(double(ends.size()), Counter::kIsIterationInvariantRate | Counter::kInvert);
            state.counters["error"] = worst_angle(ends, rays.ends);
        })->Unit(benchmark::kMillisecond);
    benchmark::RunSpecifiedBenchmarks();
    return 0;
} catch (const std::exception& error) {
    std::fprintf(stderr, "bench_peers: %s\n", error.what());
    return 2;
}

// Question: how fast and how accurate are the steppers of Boost.Odeint for a list of rays around the black hole of
// scenes/hole.toml? Each method integrates the rays from their starts to the escape sphere. The counter `error` is the
// greatest angle, in radians, between the directions of the ray ends and those of gauss16 with step 0.1.
//
//     bench_peers --rays=FILE [options of Google Benchmark]
#include "bench/odeint.h"
#include "error.h"
#include "modules/modules.h"
#include "rays/start_rays.h"
#include "render/trace.h"
#include "report/csv/read_rays.h"
#include "scene/load/load.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <limits>

namespace {

using namespace kagero;

/// The rays of the file, and their ends by the reference method.
struct Rays {
    bench::Hole hole;
    std::vector<RayStart> starts;
    std::vector<RayEnd> ends;
};

Rays rays_of(const char* file) {
    Options options;
    options.threads = 1;
    const std::vector<Override> reference_method{"integrator.method=gauss16", "integrator.step=0.1",
                                                 "integrator.symmetry=none"};
    const auto plan = make_plan(load_scene(KAGERO_SCENES "/hole.toml", reference_method, catalogue(options.isa)),
                                options, Purpose::ray_list);
    std::ifstream in(file);
    if (!in)
        throw InputError(std::string("cannot read the rays '") + file +
                         "': the file does not exist or is not readable");
    Rays rays{{plan.scene->space.parameters[0], plan.scene->limits.escape_radius},
              start_rays(plan, read_rays(in, file)),
              {}};
    trace(plan, rays.starts, rays.ends);
    return rays;
}

/// Returns the greatest angle between the end directions of a ray and its reference, in radians. Infinity if the status
/// of a ray differs.
double worst_angle(const std::vector<RayEnd>& ends, const std::vector<RayEnd>& reference) {
    double worst = 0;
    for (std::size_t i = 0; i < ends.size(); ++i) {
        if (ends[i].status != reference[i].status) return std::numeric_limits<double>::infinity();
        const double* a = ends[i].v;
        const double* b = reference[i].v;
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
    for (const bench::OdeintMethod& method : bench::odeint_methods())
        benchmark::RegisterBenchmark(("odeint/" + method.name).c_str(), [&rays, method](benchmark::State& state) {
            std::vector<RayEnd> ends(rays.starts.size());
            for (auto _ : state) method.integrate(rays.hole, method.number, rays.starts, ends);
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

// Question: what does a ray cost if each ray has its own parameters? Traces one ray for 10⁴ values of a parameter, and
// 10⁴ rays that start almost like it with one value, on one thread. The parameter varies by 2 %, and so do the
// directions, so that the rays of both rows take about the same number of steps. The times include the starts of the
// rays and the ends in the coordinates of the scene.
#include "sweep/sweep.h"
#include "modules/modules.h"
#include "rays/start_rays.h"
#include "render/trace.h"
#include "scene/load/load.h"
#include "tuning/resolve.h"

#include <benchmark/benchmark.h>

#include <cstdio>
#include <string>
#include <vector>

namespace {

using namespace kagero;

/// A space with the key that the sweep changes.
struct SweepCase {
    const char *name, *space, *key;
    double value;
};
const SweepCase cases[] = {
    {"schwarzschild", "space.hamiltonian = 'schwarzschild'\n", "space.rg", 0.5},
    {"kerr", "space.hamiltonian = 'kerr'\n", "space.spin", 0.7},
    {"wormhole", "space.hamiltonian = 'wormhole'\n", "space.throat", 0.5},
    {"fisheye", "space.hamiltonian = 'fisheye'\n", "space.radius", 3},
    {"shimmer", "space.hamiltonian = 'shimmer'\n", "space.n0", 1.2},
    {"lens",
     "[space]\nhamiltonian = 'formula'\nH = '(px^2 + py^2 + pz^2 - n^2)/2'\n"
     "[space.constants]\na = 0.2\nw = 3\n[space.let]\nn = '1 + a*exp(-(x^2 + y^2 + z^2)/w^2)'\n",
     "space.constants.a", 0.2},
    {"charged-hole",
     "[space]\nhamiltonian = 'formula'\nH = '(px^2 + py^2 + pz^2 - pt^2 - (2*m/r - k^2/r^2)*(pt + pr)^2)/2'\n"
     "capture = 'r - m - sqrt(m^2 - k^2)'\nlength_scale = '0.25*r'\n"
     "[space.constants]\npt = 1\nm = 0.25\nk = 0.15\n",
     "space.constants.m", 0.25},
};

constexpr std::size_t count = 10000;
constexpr double variation = 0.02;

/// Returns a factor near 1 for ray or set i.
double factor_of(std::size_t i) { return 1 + variation * (double(i) / count - 0.5); }

PlanWithOverrides planner_of(const SweepCase& sweep_case) {
    return [&sweep_case](const std::vector<std::string>& overrides) {
        Options options;
        options.energy_error = options.parameter = true;
        options.threads = 1;
        return resolve(load_scene_text(sweep_case.space, "sweep.toml", {overrides.begin(), overrides.end()},
                                       catalogue(options.isa), SceneUse::single_rays),
                       options, Purpose::ray_list);
    };
}

RayInput ray_with_slope(double slope) { return {{-20, 2.5, 0.3}, {1, slope, 0.01}}; }

void count_steps(benchmark::State& state, const std::vector<RayEnd>& ends) {
    double steps = 0;
    for (const RayEnd& end : ends) steps += end.steps;
    state.counters["steps/ray"] = steps / count;
    state.counters["s/ray"] =
        benchmark::Counter(count, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

/// Traces one ray for many values of the parameter.
void one_ray(benchmark::State& state, const SweepCase& sweep_case) {
    const Plan plan = planner_of(sweep_case)({});
    SweptKey key{sweep_case.key, {}};
    for (std::size_t i = 0; i < count; ++i) key.values.push_back(sweep_case.value * factor_of(i));
    const PlanWithOverrides made_before = [&](const std::vector<std::string>&) { return plan; };
    SweepResult result;
    for (auto _ : state) result = sweep(made_before, {key}, {ray_with_slope(0.02)});
    if (!result.reason_against_packets.empty()) state.SkipWithError(result.reason_against_packets.c_str());
    count_steps(state, result.ends);
}

/// Traces many rays with one value of the parameter.
void one_set(benchmark::State& state, const SweepCase& sweep_case) {
    char override_text[100];
    std::snprintf(override_text, sizeof override_text, "%s=%.17g", sweep_case.key, sweep_case.value);
    const Plan plan = planner_of(sweep_case)({override_text});
    std::vector<RayInput> rays;
    for (std::size_t i = 0; i < count; ++i) rays.push_back(ray_with_slope(0.02 * factor_of(i)));
    std::vector<RayEnd> ends;
    for (auto _ : state) trace(plan, start_rays(plan, rays), ends);
    count_steps(state, ends);
}

void add(const SweepCase& sweep_case, const char* row,
         void (*measure)(benchmark::State& state, const SweepCase& sweep_case)) {
    const std::string name = std::string("sweep/") + sweep_case.name + "." + sweep_case.key + "/" + row;
    benchmark::RegisterBenchmark(name.c_str(),
                                 [&sweep_case, measure](benchmark::State& state) { measure(state, sweep_case); })
        ->UseRealTime()
        ->Unit(benchmark::kMillisecond);
}

}  // namespace

int main(int argument_count, char** arguments) {
    for (const SweepCase& sweep_case : cases) {
        add(sweep_case, "one_ray", one_ray);
        add(sweep_case, "one_set", one_set);
    }
    benchmark::Initialize(&argument_count, arguments);
    if (benchmark::ReportUnrecognizedArguments(argument_count, arguments)) return 2;
    benchmark::RunSpecifiedBenchmarks();
    return 0;
}

// What does one step of each integrator cost per ray?
//
// Rays pass the origin at a third of their starting distance, along the same way for every integrator: in steps of 1/20, or of 1/4 for
// orders above 5. Lanes have slightly different rays, so implicit solves wait for the slowest of a packet as they do in a picture.
#include "kernels/stepping/space_kernel.h"
#include "kernels/tracing/packets.h"
#include "all_hamiltonians.inc"

#include <benchmark/benchmark.h>

#include <memory>
#include <string>

namespace kagero {
namespace {

constexpr double way = 2;

double step_of(const Method& method) { return method.info.order > 5 ? 0.25 : 0.05; }

/// Parameters at their fallbacks, but a hole as small as the room's.
template <class H>
auto parameters_of() {
    std::array<double, H::parameters.size() + 1> values{};
    for (std::size_t i = 0; i < H::parameters.size(); ++i) {
        const ParameterInfo& p = H::parameters[i];
        values[i] = std::string(p.name) == "rg" ? 0.08 : p.fallback;
    }
    return values;
}

/// Rays side by side at x = −1, moving along x, started on no particular level of H: the work is the same.
template <class V>
void aim(Flow<V>& f, double pt) {
    using S = ScalarOf<V>;
    for (int i = 0; i < lane_count<V>; ++i) {
        const double y[7] = {-1, 0.3 + 0.002 * (i % 4), 0.1 + 0.002 * (i / 4), 0.98, 0.1, 0.02, pt};
        for (int k = 0; k < 7; ++k) set_lane(f.start.y[k], i, S(y[k]));
    }
    f.start_parameter = f.end_parameter = f.gradients = f.energy = f.energy_error = V(S(0));
}

template <class V>
KAGERO_INLINE void commit(Flow<V>& f) {
    for (int k = 0; k < 6; ++k) f.start.y[k] = f.end.y[k];
    f.start_velocity = f.end_velocity;
}

template <class V>
double total(const V& v) {
    double sum = 0;
    for (int i = 0; i < lane_count<V>; ++i) sum += double(get_lane(v, i));
    return sum;
}

template <class H, class V>
void steps(benchmark::State& state, const Method& method, bool rescaled) {
    const SpaceKernel<V>& kernel = space_kernel<H, V>(rescaled);
    const auto parameters = parameters_of<H>();
    const auto kind = static_cast<int>(method.kind);
    const auto system = std::make_unique<SystemStorage>();
    kernel.construct(*system, parameters.data());
    const auto start = std::make_unique<Flow<V>>(), flow = std::make_unique<Flow<V>>();
    aim(*start, H::spacetime ? 1.0 : 0.0);
    start->h = V(ScalarOf<V>(step_of(method)));
    start->tolerance = ScalarOf<V>(1e-6);  // adaptive methods estimate their error, but every step counts here
    kernel.begin[kind](*system, *start, method.coefficients);
    const int count = static_cast<int>(way / step_of(method));
    for (auto _ : state) {
        *flow = *start;
        for (int i = 0; i < count; ++i) {
            kernel.step[kind](*system, *flow, method.coefficients);
            commit(*flow);
        }
        benchmark::ClobberMemory();
    }
    const double ray_steps = double(state.iterations()) * count * lane_count<V>;
    state.counters["steps/s"] = benchmark::Counter(ray_steps, benchmark::Counter::kIsRate);
    state.counters["s/step"] = benchmark::Counter(ray_steps, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
    state.counters["gradients/step"] = total(flow->gradients) / (count * lane_count<V>);
    if (flow->issued_iterations)
        state.counters["iterating"] = total(flow->open_iterations) / (double(flow->issued_iterations) * lane_count<V>);
}

template <class H, class V>
void add(const char* type) {
    for (const bool rescaled : {false, true}) {
        if (rescaled && !Rescalable<H>) continue;
        for (const Method& method : methods) {
            if (space_kernel<H, V>(rescaled).refusal[static_cast<int>(method.kind)]) continue;
            const std::string path =
                std::string("step/") + H::name + (rescaled ? "_rescaled/" : "/") + method.info.name + "/" + type;
            benchmark::RegisterBenchmark(
                path.c_str(), [&method, rescaled](benchmark::State& state) { steps<H, V>(state, method, rescaled); });
        }
    }
}

const bool added = [] {
#define KAGERO_HAMILTONIAN(TYPE)                             \
    add<hamiltonians::TYPE, PacketDouble>("packet_double");  \
    add<hamiltonians::TYPE, PacketFloat>("packet_float");    \
    add<hamiltonians::TYPE, double>("double");               \
    add<hamiltonians::TYPE, float>("float");
#include "hamiltonians.inc"
#undef KAGERO_HAMILTONIAN
    return true;
}();

}  // namespace
}  // namespace kagero

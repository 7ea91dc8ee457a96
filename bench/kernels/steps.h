/// One step after another of a ray per lane, and what that costs.
///
/// Rays pass the origin at a third of their starting distance, along the same way for every integrator: in steps of
/// 1/10, or of 1/2 for orders above 5, as in the pictures that they are compared with. Lanes have slightly different
/// rays, so implicit solves wait for the slowest of a packet as they do in a picture.
#pragma once

#include "kernels/simd/peak.h"
#include "kernels/methods/methods.h"
#include "kernels/methods/space_kernel.h"
#include "kernels/trace/packets.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

namespace kagero::bench {

inline constexpr double way = 2;

inline double step_of(const Method& method) { return method.info.order > 5 ? 0.5 : 0.1; }

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
void aim(StepperState<V>& f, double pt) {
    using S = ScalarOf<V>;
    for (int i = 0; i < lane_count<V>; ++i) {
        const double y[7] = {-1, 0.3 + 0.002 * (i % 4), 0.1 + 0.002 * (i / 4), 0.98, 0.1, 0.02, pt};
        for (int k = 0; k < 7; ++k) set_lane(f.start.y[k], i, S(y[k]));
    }
    f.start.parameter = f.end.parameter = f.gradients = f.energy = f.energy_error = V(S(0));
}

template <class V>
KAGERO_INLINE void commit(StepperState<V>& f) {
    for (int k = 0; k < 6; ++k) f.start.y[k] = f.end.y[k];
    f.start.velocity = f.end.velocity;
}

template <class V>
double total(const V& v) {
    double sum = 0;
    for (int i = 0; i < lane_count<V>; ++i) sum += double(get_lane(v, i));
    return sum;
}

/// Multiply-adds alone, operations per second, measured once in this process: the best of five runs of some
/// milliseconds.
template <class T>
double peak() {
    static const double best = [] {
        double most = 0;
        for (int run = 0; run < 5; ++run) {
            const auto begin = std::chrono::steady_clock::now();
            const double operations = multiply_adds<T>(1 << 21);
            most = std::max(most, operations /
                                      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
        }
        return most;
    }();
    return best;
}

/// Ends the program unless two kernels take the same step: a rival that solves another problem is none.
template <class H, class V>
void require_same_step(const Method& method, const SpaceKernel<V>& one, const SpaceKernel<V>& other) {
    using S = ScalarOf<V>;
    const auto parameters = parameters_of<H>();
    const auto kind = static_cast<int>(method.kind);
    const auto flow_of = [&](const SpaceKernel<V>& kernel) {
        const auto system = std::make_unique<SystemStorage>();
        kernel.construct(*system, parameters.data());
        auto flow = std::make_unique<StepperState<V>>();
        aim(*flow, H::spacetime ? 1.0 : 0.0);
        flow->h = V(S(step_of(method)));
        kernel.begin[kind](*system, *flow, method.coefficients);
        kernel.step[kind](*system, *flow, method.coefficients);
        return flow;
    };
    const auto a = flow_of(one), b = flow_of(other);
    const double roundings = 1000 * double(machine_epsilon<S>);
    for (int k = 0; k < 6; ++k)
        for (int i = 0; i < lane_count<V>; ++i) {
            if (std::abs(double(get_lane(a->end.y[k], i)) - double(get_lane(b->end.y[k], i))) <= roundings) continue;
            std::fprintf(stderr, "%s: two ways to take the same step end apart\n", method.info.name);
            std::abort();
        }
}

template <class H, class V>
void steps(benchmark::State& state, const Method& method, const SpaceKernel<V>& kernel) {
    const auto parameters = parameters_of<H>();
    const auto kind = static_cast<int>(method.kind);
    const auto system = std::make_unique<SystemStorage>();
    kernel.construct(*system, parameters.data());
    const auto start = std::make_unique<StepperState<V>>(), flow = std::make_unique<StepperState<V>>();
    aim(*start, H::spacetime ? 1.0 : 0.0);
    start->h = V(ScalarOf<V>(step_of(method)));
    start->options.tolerance = ScalarOf<V>(1e-6);  // adaptive methods estimate their error, but every step counts here
    kernel.begin[kind](*system, *start, method.coefficients);
    const int count = static_cast<int>(way / step_of(method));
    const int stages =
        method.coefficients.gauss ? method.coefficients.gauss->stages : 2;  // whose derivatives a step begins with
    *flow = *start;
    for (auto _ : state) {
        flow->start = start->start;
        flow->gradients = flow->open_iterations = V(ScalarOf<V>(0)), flow->issued_iterations = 0;
        for (int stage = 0; stage < stages; ++stage)
            std::copy(start->stage[stage], start->stage[stage] + 6, flow->stage[stage]);
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
    const Operations cost = operations_of(method, kernel.operations);
    const double per_step = cost.per_step + cost.per_gradient * total(flow->gradients) / (count * lane_count<V>);
    state.counters["of_peak"] =
        benchmark::Counter(ray_steps * per_step / peak<ScalarOf<V>>(), benchmark::Counter::kIsRate);
    if (flow->issued_iterations)
        state.counters["iterating"] = total(flow->open_iterations) / (double(flow->issued_iterations) * lane_count<V>);
}

}  // namespace kagero::bench

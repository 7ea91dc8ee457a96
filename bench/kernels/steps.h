/// Times of consecutive steps of one method, with one ray per lane and without a scene.
///
/// All methods integrate over the same interval of the parameter λ or τ, in steps of 1/10, or of 1/2 for orders
/// above 5. The rays pass the origin at less than half of their initial distance. The rays of a packet differ slightly,
/// so that the number of iterations of an implicit step is that of the slowest lane, as in a picture.
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

/// Interval of the integration parameter: λ, or τ with time rescaling.
inline constexpr double parameter_interval = 2;

inline double step_of(const Method& method) { return method.info.order > 5 ? 0.5 : 0.1; }

/// Returns the default parameters of H, except r_g, which is that of scenes/room.toml.
template <class H>
auto parameters_of() {
    std::array<double, H::parameters.size() + 1> values{};
    for (std::size_t i = 0; i < H::parameters.size(); ++i) {
        const ParameterInfo& p = H::parameters[i];
        values[i] = std::string(p.name) == "rg" ? 0.08 : p.default_value;
    }
    return values;
}

/// Sets the starts of adjacent rays that move from x = −1 along x. H of these states is not H0, which does not change
/// the work per step.
template <class V>
void set_ray_starts(StepperState<V>& f, double pt) {
    using S = ScalarOf<V>;
    for (int i = 0; i < lane_count<V>; ++i) {
        const double y[7] = {-1, 0.3 + 0.002 * (i % 4), 0.1 + 0.002 * (i / 4), 0.98, 0.1, 0.02, pt};
        for (int k = 0; k < 7; ++k) set_lane(f.start.y[k], i, S(y[k]));
    }
    f.start.parameter = f.end.parameter = f.gradients = f.energy = f.energy_error = V(S(0));
}

/// Makes the end of the step the start of the next step.
template <class V>
KAGERO_INLINE void start_next_step(StepperState<V>& f) {
    for (int k = 0; k < 6; ++k) f.start.y[k] = f.end.y[k];
    f.start.velocity = f.end.velocity;
}

template <class V>
double sum_of_lanes(const V& v) {
    double sum = 0;
    for (int i = 0; i < lane_count<V>; ++i) sum += double(get_lane(v, i));
    return sum;
}

/// Returns the peak rate of multiply-adds of type T in operations per second: the greatest rate of five runs of some
/// milliseconds. The rate is measured once per process.
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

/// Ends the program unless a step of both kernels ends in the same state, to rounding.
template <class H, class V>
void require_same_step(const Method& method, const SpaceKernel<V>& first, const SpaceKernel<V>& second) {
    using S = ScalarOf<V>;
    const auto parameters = parameters_of<H>();
    const auto kind = static_cast<int>(method.kind);
    const auto state_after_step = [&](const SpaceKernel<V>& kernel) {
        const auto system = std::make_unique<SystemStorage>();
        kernel.construct(*system, parameters.data());
        auto state = std::make_unique<StepperState<V>>();
        set_ray_starts(*state, H::spacetime ? 1.0 : 0.0);
        state->h = V(S(step_of(method)));
        kernel.begin[kind](*system, *state, method.coefficients);
        kernel.step[kind](*system, *state, method.coefficients);
        return state;
    };
    const auto a = state_after_step(first), b = state_after_step(second);
    const double tolerance = 1000 * double(machine_epsilon<S>);
    for (int k = 0; k < 6; ++k)
        for (int i = 0; i < lane_count<V>; ++i) {
            const double difference = std::abs(double(get_lane(a->end.y[k], i)) - double(get_lane(b->end.y[k], i)));
            if (difference <= tolerance) continue;
            std::fprintf(stderr, "%s: variable %d after a step differs by %g between two kernels; at most %g is "
                         "rounding\n",
                         method.info.name, k, difference, tolerance);
            std::abort();
        }
}

/// Measures the time of steps: each iteration of the benchmark integrates over `parameter_interval` from the same
/// start.
template <class H, class V>
void measure_steps(benchmark::State& state, const Method& method, const SpaceKernel<V>& kernel) {
    const auto parameters = parameters_of<H>();
    const auto kind = static_cast<int>(method.kind);
    const auto system = std::make_unique<SystemStorage>();
    kernel.construct(*system, parameters.data());
    const auto initial = std::make_unique<StepperState<V>>(), current = std::make_unique<StepperState<V>>();
    set_ray_starts(*initial, H::spacetime ? 1.0 : 0.0);
    initial->h = V(ScalarOf<V>(step_of(method)));
    initial->options.tolerance = ScalarOf<V>(1e-6);  // so large that no step is rejected for its estimated error
    kernel.begin[kind](*system, *initial, method.coefficients);
    const int count = static_cast<int>(parameter_interval / step_of(method));
    // Number of stages whose values the stepper keeps from one step to the next.
    const int stages = method.coefficients.gauss ? method.coefficients.gauss->stages : 2;
    *current = *initial;
    for (auto _ : state) {
        current->start = initial->start;
        current->gradients = current->lane_iterations = V(ScalarOf<V>(0));
        current->issued_iterations = 0;
        for (int stage = 0; stage < stages; ++stage)
            std::copy(initial->stage[stage], initial->stage[stage] + 6, current->stage[stage]);
        for (int i = 0; i < count; ++i) {
            kernel.step[kind](*system, *current, method.coefficients);
            start_next_step(*current);
        }
        benchmark::ClobberMemory();
    }
    const double ray_steps = double(state.iterations()) * count * lane_count<V>;
    state.counters["steps/s"] = benchmark::Counter(ray_steps, benchmark::Counter::kIsRate);
    state.counters["s/step"] = benchmark::Counter(ray_steps, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
    state.counters["gradients/step"] = sum_of_lanes(current->gradients) / (count * lane_count<V>);
    const Operations cost = operations_of(method, kernel.operations);
    const double per_step =
        cost.per_step + cost.per_gradient * sum_of_lanes(current->gradients) / (count * lane_count<V>);
    state.counters["of_peak"] =
        benchmark::Counter(ray_steps * per_step / peak<ScalarOf<V>>(), benchmark::Counter::kIsRate);
    if (current->issued_iterations)
        state.counters["iterating"] =
            sum_of_lanes(current->lane_iterations) / (double(current->issued_iterations) * lane_count<V>);
}

}  // namespace kagero::bench

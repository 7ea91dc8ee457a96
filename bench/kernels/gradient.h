/// Question: how long does one gradient of H take per ray? H is equation (16) of Satoh (2003).
///
/// The benchmark `chain` measures the latency of a gradient: each state depends on the previous gradient, as in an
/// explicit step. The benchmark `independent` measures the throughput: the states do not depend on each other, as at
/// the stages of a Gauss step.
#pragma once

#include "bench/kernels/gradient_methods.h"

#include <benchmark/benchmark.h>

#include <cstdio>
#include <cstdlib>
#include <string>

namespace kagero::bench {

inline constexpr double hole_parameters[1] = {0.08};  ///< r_g of scenes/room.toml.
inline constexpr int state_count = 8;                 ///< Number of different ray states per lane.

/// Returns ray state `number` in scenes/room.toml. The lanes hold consecutive elements of a low-discrepancy sequence.
template <class V>
State<V> ray_state(int number) {
    using S = ScalarOf<V>;
    State<V> s;
    for (int lane = 0; lane < lane_count<V>; ++lane) {
        const double i = number * lane_count<V> + lane + 1;
        const auto fraction = [i](double a) { return i * a - double(long(i * a)); };
        const double y[7] = {0.3 + fraction(0.819),
                             -0.9 + fraction(0.671),
                             0.1 + fraction(0.550),
                             -0.5 + fraction(0.451),
                             0.7 + 0.2 * fraction(0.369),
                             0.1 + fraction(0.303),
                             1};
        for (int k = 0; k < 7; ++k) set_lane(s.y[k], lane, S(y[k]));
    }
    return s;
}

/// Ends the program unless the derivatives of a method agree with those of the tape to rounding.
template <class V, class Gradient, class Tape>
void require_agreement(const Gradient& gradient, const Tape& tape, const char* name) {
    using S = ScalarOf<V>;
    for (int n = 0; n < state_count; ++n) {
        const State<V> s = ray_state<V>(n);
        V actual[6], reference[6];
        gradient.derivatives(s, actual);
        tape.derivatives(s, reference);
        for (int lane = 0; lane < lane_count<V>; ++lane) {
            S size = 0;
            for (int k = 0; k < 6; ++k) size = max(size, S(std::abs(get_lane(reference[k], lane))));
            for (int k = 0; k < 6; ++k) {
                const S difference = std::abs(get_lane(actual[k], lane) - get_lane(reference[k], lane));
                const S tolerance = 32 * machine_epsilon<S> * size;
                if (difference <= tolerance) continue;
                std::fprintf(stderr, "%s: derivative %d differs from that of the tape by %g; at most %g is rounding\n",
                             name, k, double(difference), double(tolerance));
                std::abort();
            }
        }
    }
}

/// Sets the counters of a benchmark that computed `gradients` gradients in every lane.
template <class V>
void set_counters(benchmark::State& state, double gradients) {
    const double rays = gradients * lane_count<V>;
    state.counters["rays/s"] = benchmark::Counter(rays, benchmark::Counter::kIsRate);
    state.counters["s/ray"] = benchmark::Counter(rays, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
    state.counters["lanes"] = lane_count<V>;
}

template <class V, class Gradient>
void chain(benchmark::State& state) {
    const Gradient gradient(hole_parameters);
    State<V> s = ray_state<V>(0);
    const V step(ScalarOf<V>(1e-15));  // so small that the state stays almost constant
    constexpr int length = 64;
    for (auto _ : state) {
        for (int i = 0; i < length; ++i) {
            V d[6];
            gradient.derivatives(s, d);
            for (int k = 0; k < 6; ++k) s.y[k] = fma(step, d[k], s.y[k]);
        }
        benchmark::DoNotOptimize(&s);
        benchmark::ClobberMemory();
    }
    set_counters<V>(state, double(state.iterations()) * length);
}

template <class V, class Gradient>
void independent(benchmark::State& state) {
    const Gradient gradient(hole_parameters);
    State<V> s[state_count];
    V d[state_count][6];
    for (int i = 0; i < state_count; ++i) s[i] = ray_state<V>(i);
    benchmark::DoNotOptimize(&s);
    benchmark::DoNotOptimize(&d);
    for (auto _ : state) {
        benchmark::ClobberMemory();
        for (int i = 0; i < state_count; ++i) gradient.derivatives(s[i], d[i]);
        benchmark::ClobberMemory();
    }
    set_counters<V>(state, double(state.iterations()) * state_count);
}

/// Registers the benchmarks of one method for the gradient. Ends the program if the method disagrees with the tape.
template <class V, template <class, bool> class Method, bool Rescaled>
void add_method(const std::string& type) {
    using Gradient = Method<V, Rescaled>;
    const std::string path =
        std::string(Rescaled ? "gradient_of_rH/" : "gradient_of_H/") + Gradient::name + "/" + type + "/";
    require_agreement<V>(Gradient(hole_parameters), ReverseTape<V, Rescaled>(hole_parameters), path.c_str());
    benchmark::RegisterBenchmark((path + "chain").c_str(), chain<V, Gradient>);
    benchmark::RegisterBenchmark((path + "independent").c_str(), independent<V, Gradient>);
}

template <class V, bool Rescaled>
void add_methods(const std::string& type) {
    add_method<V, HandWritten, Rescaled>(type);
    add_method<V, ReverseTape, Rescaled>(type);
    add_method<V, SparseForward, Rescaled>(type);
    add_method<V, DenseForward, Rescaled>(type);
}

/// Registers the benchmarks of all methods for the gradients of H and of r·H, for one value type.
template <class V>
void add_gradients(const std::string& type) {
    add_methods<V, false>(type);
    add_methods<V, true>(type);
}

}  // namespace kagero::bench

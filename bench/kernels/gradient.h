/// What does a gradient of (16) cost per ray?
///
/// `chain`: each input is the last one moved by a hair along the derivatives, so the latency of a whole gradient is
/// seen, as in an explicit step. `independent`: gradients at many places, none waiting for another, as at the stages of
/// a Gauss step.
#pragma once

#include "bench/kernels/gradient_rivals.h"

#include <benchmark/benchmark.h>

#include <cstdio>
#include <cstdlib>
#include <string>

namespace kagero::bench {

inline constexpr double hole[1] = {0.08};
inline constexpr int places = 8;

/// Rays of the room, all different: number i of a low-discrepancy sequence.
template <class V>
State<V> ray_state(int number) {
    using S = ScalarOf<V>;
    State<V> s;
    for (int lane = 0; lane < lane_count<V>; ++lane) {
        const double i = number * lane_count<V> + lane + 1;
        const auto part = [i](double a) { return i * a - double(long(i * a)); };
        const double y[7] = {0.3 + part(0.819),
                             -0.9 + part(0.671),
                             0.1 + part(0.550),
                             -0.5 + part(0.451),
                             0.7 + 0.2 * part(0.369),
                             0.1 + part(0.303),
                             1};
        for (int k = 0; k < 7; ++k) set_lane(s.y[k], lane, S(y[k]));
    }
    return s;
}

/// Stops the program unless the rival's derivatives are the tape's, to rounding.
template <class V, class Rival, class Tape>
void require_agreement(const Rival& rival, const Tape& tape, const char* what) {
    using S = ScalarOf<V>;
    for (int place = 0; place < places; ++place) {
        const State<V> s = ray_state<V>(place);
        V mine[6], reference[6];
        rival.derivatives(s, mine);
        tape.derivatives(s, reference);
        for (int lane = 0; lane < lane_count<V>; ++lane) {
            S size = 0;
            for (int k = 0; k < 6; ++k) size = max(size, S(std::abs(get_lane(reference[k], lane))));
            for (int k = 0; k < 6; ++k) {
                const S off = std::abs(get_lane(mine[k], lane) - get_lane(reference[k], lane));
                if (off <= 32 * machine_epsilon<S> * size) continue;
                std::fprintf(stderr, "%s: derivative %d is off by %g of %g\n", what, k, double(off), double(size));
                std::abort();
            }
        }
    }
}

template <class V>
void count_rays(benchmark::State& state, double gradients) {
    const double rays = gradients * lane_count<V>;
    state.counters["rays/s"] = benchmark::Counter(rays, benchmark::Counter::kIsRate);
    state.counters["s/ray"] = benchmark::Counter(rays, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
    state.counters["lanes"] = lane_count<V>;
}

template <class V, class Rival>
void chain(benchmark::State& state) {
    const Rival rival(hole);
    State<V> s = ray_state<V>(0);
    const V hair(ScalarOf<V>(1e-15));
    constexpr int length = 64;
    for (auto _ : state) {
        for (int i = 0; i < length; ++i) {
            V d[6];
            rival.derivatives(s, d);
            for (int k = 0; k < 6; ++k) s.y[k] = fma(hair, d[k], s.y[k]);
        }
        benchmark::DoNotOptimize(&s);
        benchmark::ClobberMemory();
    }
    count_rays<V>(state, double(state.iterations()) * length);
}

template <class V, class Rival>
void independent(benchmark::State& state) {
    const Rival rival(hole);
    State<V> s[places];
    V d[places][6];
    for (int i = 0; i < places; ++i) s[i] = ray_state<V>(i);
    benchmark::DoNotOptimize(&s);
    benchmark::DoNotOptimize(&d);
    for (auto _ : state) {
        benchmark::ClobberMemory();
        for (int i = 0; i < places; ++i) rival.derivatives(s[i], d[i]);
        benchmark::ClobberMemory();
    }
    count_rays<V>(state, double(state.iterations()) * places);
}

template <class V, template <class, bool> class Rival, bool Rescaled>
void add_rival(const std::string& type) {
    using Ways = Rival<V, Rescaled>;
    const std::string path =
        std::string(Rescaled ? "gradient_of_rH/" : "gradient_of_H/") + Ways::name + "/" + type + "/";
    require_agreement<V>(Ways(hole), ReverseTape<V, Rescaled>(hole), path.c_str());
    benchmark::RegisterBenchmark((path + "chain").c_str(), chain<V, Ways>);
    benchmark::RegisterBenchmark((path + "independent").c_str(), independent<V, Ways>);
}

template <class V, bool Rescaled>
void add_rivals(const std::string& type) {
    add_rival<V, Hand, Rescaled>(type);
    add_rival<V, ReverseTape, Rescaled>(type);
    add_rival<V, SparseForward, Rescaled>(type);
    add_rival<V, DenseForward, Rescaled>(type);
}

/// Registers every rival on one value type.
template <class V>
void add_gradients(const std::string& type) {
    add_rivals<V, false>(type);
    add_rivals<V, true>(type);
}

}  // namespace kagero::bench

#include "render/peak.h"

#include "render/threads.h"

#include <algorithm>
#include <chrono>
#include <latch>
#include <vector>

namespace kagero {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// Rounds that take one thread some 20 ms.
std::uint64_t rounds_for(const Module& module, Precision precision) {
    std::uint64_t rounds = 1 << 16;
    for (;; rounds *= 2) {
        const auto begin = Clock::now();
        module.multiply_adds(precision, rounds);
        if (seconds_since(begin) > 0.01) return 2 * rounds;
    }
}

}  // namespace

double peak_operations(const Module& module, Precision precision, unsigned threads) {
    const std::uint64_t rounds = rounds_for(module, precision);
    double best = 0;
    for (int run = 0; run < 5; ++run) {
        std::vector<double> rates(threads);
        std::latch start(threads);
        on_threads(threads, [&](unsigned i) {
            start.arrive_and_wait();
            const auto begin = Clock::now();
            const double operations = module.multiply_adds(precision, rounds);
            rates[i] = operations / seconds_since(begin);
        });
        double sum = 0;
        for (const double rate : rates) sum += rate;
        best = std::max(best, sum);
    }
    return best;
}

}  // namespace kagero

#include "study/peak.h"

#include "render/threads.h"

#include <chrono>
#include <numeric>
#include <vector>

namespace kagero {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

/// Returns a number of loop iterations that takes one thread 20 to 40 ms.
std::uint64_t iterations_for(const Module& module, Precision precision) {
    std::uint64_t iterations = 1 << 16;
    for (;; iterations *= 2) {
        const auto begin = Clock::now();
        module.multiply_adds(precision, iterations);
        if (seconds_since(begin) > 0.01) return 2 * iterations;
    }
}

}  // namespace

Peak::Peak(const Module& module, Precision precision)
    : module_(module), precision_(precision), iterations_(iterations_for(module, precision)) {}

double Peak::operations_per_second(unsigned threads) const {
    std::vector<double> rates(threads);
    run_on_threads(threads, [&](unsigned i) {
        const auto begin = Clock::now();
        const double operations = module_.multiply_adds(precision_, iterations_);
        rates[i] = operations / seconds_since(begin);
    });
    return std::accumulate(rates.begin(), rates.end(), 0.0);
}

}  // namespace kagero

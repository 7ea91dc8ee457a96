/// Measures the time that parts of a kernel take, if `Job::timed` is set.
#pragma once

#include <cstdint>

namespace kagero {

/// Adds the ticks of the processor's time-stamp counter during its lifetime to `sum`. A disabled stopwatch costs one
/// branch.
class Stopwatch {
public:
    Stopwatch(bool enabled, std::uint64_t& sum)
        : sum_(enabled ? &sum : nullptr), begin_(enabled ? __builtin_ia32_rdtsc() : 0) {}
    ~Stopwatch() {
        if (sum_) *sum_ += __builtin_ia32_rdtsc() - begin_;
    }
    Stopwatch(const Stopwatch&) = delete;
    Stopwatch& operator=(const Stopwatch&) = delete;

private:
    std::uint64_t* sum_;
    std::uint64_t begin_;
};

}  // namespace kagero

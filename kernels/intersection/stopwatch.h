/// Where a kernel's time goes, asked for by `Job::timed`.
#pragma once

#include <cstdint>

namespace kagero {

/// Adds the ticks of the processor's clock that pass while it lives to `sum`. Not wanted, it is one branch.
class Stopwatch {
public:
    Stopwatch(bool wanted, std::uint64_t& sum)
        : sum_(wanted ? &sum : nullptr), begin_(wanted ? __builtin_ia32_rdtsc() : 0) {}
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

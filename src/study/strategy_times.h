/// The same rays one at a time, one per vector and in packets, on every instruction set.
#pragma once

#include "accuracy/timing.h"
#include "plan/variant.h"

#include <atomic>

namespace kagero {

/// One kernel, by the scene's own method at its own step.
struct StrategyTime {
    std::string isa;
    const KernelInfo* kernel = nullptr;
    Timing time;  ///< ns per ray
};

/// The best instruction set first; only that of the plan where its options name one. The runs are interleaved, three of
/// each at least, and no ray takes more than the plan's steps.
std::vector<StrategyTime> strategy_times(const Plan& plan, const std::vector<RayStart>& rays, unsigned threads,
                                         const std::atomic<bool>* stop);

}  // namespace kagero

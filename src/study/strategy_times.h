/// Times of the same rays with every strategy and instruction set.
#pragma once

#include "accuracy/timing.h"
#include "plan/variant.h"

#include <atomic>

namespace kagero {

/// Time of one kernel with the method and step of the scene.
struct StrategyTime {
    std::string isa;
    const KernelInfo* kernel = nullptr;
    Timing time;  ///< Nanoseconds per ray.
};

/// Returns the time of one kernel per instruction set, strategy, form and precision, the best instruction set first. If
/// the options of the plan name an instruction set, only its kernels are timed. Each kernel runs at least three times,
/// and the runs of the kernels are interleaved. Rays end after at most `plan.run.max_steps` steps. Returns early, with
/// fewer runs, if `stop` is set.
std::vector<StrategyTime> strategy_times(const Plan& plan, const std::vector<RayStart>& rays, unsigned threads,
                                         const std::atomic<bool>* stop);

}  // namespace kagero
